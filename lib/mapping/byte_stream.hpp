// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bit>
#include <cstdint>
#include <cstring>
#include <span>
#include <type_traits>
#include <vector>

namespace cairn::mapping {

static_assert(std::endian::native == std::endian::little, "the map file is little endian");

/// Appends numbers to bytes, little endian.
class ByteWriter {
 public:
  template <class T>
  void put(T value) {
    static_assert(std::is_arithmetic_v<T>);
    append(&value, sizeof(T));
  }
  void put_bytes(std::span<const std::uint8_t> more) {
    if (!more.empty()) append(more.data(), more.size());
  }
  [[nodiscard]] std::span<const std::uint8_t> from(std::size_t position) const {
    return std::span{bytes_}.subspan(position);
  }
  [[nodiscard]] std::size_t size() const { return bytes_.size(); }
  [[nodiscard]] std::vector<std::uint8_t> take() { return std::move(bytes_); }

 private:
  void append(const void* more, std::size_t count) {
    const std::size_t at = bytes_.size();
    bytes_.resize(at + count);
    std::memcpy(bytes_.data() + at, more, count);
  }

  std::vector<std::uint8_t> bytes_;
};

/// Reads what ByteWriter wrote. Reading past the end gives false and leaves the value.
class ByteReader {
 public:
  explicit ByteReader(std::span<const std::uint8_t> bytes) : bytes_{bytes} {}

  template <class T>
  [[nodiscard]] bool get(T& value) {
    static_assert(std::is_arithmetic_v<T>);
    if (left() < sizeof(T)) return false;
    std::memcpy(&value, bytes_.data() + at_, sizeof(T));
    at_ += sizeof(T);
    return true;
  }
  [[nodiscard]] bool get_bytes(std::size_t count, std::span<const std::uint8_t>& value) {
    if (left() < count) return false;
    value = bytes_.subspan(at_, count);
    at_ += count;
    return true;
  }
  [[nodiscard]] std::size_t position() const { return at_; }
  [[nodiscard]] std::size_t left() const { return bytes_.size() - at_; }
  [[nodiscard]] std::span<const std::uint8_t> between(std::size_t first, std::size_t last) const {
    return bytes_.subspan(first, last - first);
  }

 private:
  std::span<const std::uint8_t> bytes_;
  std::size_t at_ = 0;
};

}  // namespace cairn::mapping
