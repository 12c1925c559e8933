// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace cairn::messages {

/// How likely a bit is 0, learned from the bits that were coded with it.
struct BitModel {
  std::uint16_t zero_4096ths = 2048;

  void learn(bool bit) {
    constexpr int kRate = 4;
    if (bit) {
      zero_4096ths = static_cast<std::uint16_t>(zero_4096ths - (zero_4096ths >> kRate));
    } else {
      zero_4096ths = static_cast<std::uint16_t>(zero_4096ths + ((4096 - zero_4096ths) >> kRate));
    }
  }
  [[nodiscard]] std::uint32_t share_of(std::uint32_t range) const {
    return (range >> 12) * zero_4096ths;
  }
};

/// Binary adaptive range coder with carry (Martin 1979; the carry as in LZMA, Pavlov).
class RangeEncoder {
 public:
  void put(BitModel& model, bool bit) {
    const std::uint32_t zero = model.share_of(range_);
    if (bit) {
      low_ += zero;
      range_ -= zero;
    } else {
      range_ = zero;
    }
    model.learn(bit);
    for (; range_ < kMinRange; range_ <<= 8) shift();
  }

  /// All bytes; the encoder is spent.
  [[nodiscard]] std::vector<std::uint8_t> finish() {
    for (int i = 0; i < 5; ++i) shift();
    return std::move(bytes_);
  }

 private:
  friend class RangeDecoder;
  static constexpr std::uint32_t kMinRange = 1U << 24;

  void shift() {
    if (low_ < 0xff000000U || low_ > 0xffffffffU) {
      const auto carry = static_cast<std::uint8_t>(low_ >> 32);
      for (std::uint8_t byte = first_waiting_; waiting_ > 0; --waiting_, byte = 0xff) {
        bytes_.push_back(static_cast<std::uint8_t>(byte + carry));
      }
      first_waiting_ = static_cast<std::uint8_t>(low_ >> 24);
    }
    ++waiting_;
    low_ = (low_ & 0x00ffffffU) << 8;
  }

  std::uint64_t low_ = 0;
  std::uint32_t range_ = 0xffffffffU;
  std::uint8_t first_waiting_ = 0;
  std::size_t waiting_ = 1;
  std::vector<std::uint8_t> bytes_;
};

/// Reads what a RangeEncoder wrote. Damaged bytes give other bits, never harm; past the end come
/// zeros.
class RangeDecoder {
 public:
  explicit RangeDecoder(std::span<const std::uint8_t> bytes) : bytes_(bytes) {
    for (int i = 0; i < 5; ++i) code_ = code_ << 8 | next_byte();
  }

  [[nodiscard]] bool get(BitModel& model) {
    const std::uint32_t zero = model.share_of(range_);
    const bool bit = code_ >= zero;
    if (bit) {
      code_ -= zero;
      range_ -= zero;
    } else {
      range_ = zero;
    }
    model.learn(bit);
    for (; range_ < RangeEncoder::kMinRange; range_ <<= 8) code_ = code_ << 8 | next_byte();
    return bit;
  }

  /// Whether as many bytes were read as there are.
  [[nodiscard]] bool exhausted() const { return read_ == bytes_.size(); }

 private:
  std::uint32_t next_byte() {
    const std::size_t at = read_++;
    return at < bytes_.size() ? bytes_[at] : 0;
  }

  std::span<const std::uint8_t> bytes_;
  std::size_t read_ = 0;
  std::uint32_t range_ = 0xffffffffU;
  std::uint32_t code_ = 0;
};

}  // namespace cairn::messages
