// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

namespace cairn::spy {

/// Reads LCM's wire format (big endian) front to back and never past the end: nothing comes back
/// where too few bytes are left.
class WireReader {
 public:
  explicit WireReader(std::span<const std::uint8_t> bytes) : bytes_{bytes} {}

  [[nodiscard]] std::size_t left() const { return bytes_.size(); }
  [[nodiscard]] std::optional<std::uint64_t> unsigned_integer(std::size_t size);
  [[nodiscard]] std::optional<std::int64_t> signed_integer(std::size_t size);
  /// A length that counts a closing zero, then the characters. They live as long as the bytes do.
  [[nodiscard]] std::optional<std::string_view> text();
  /// False, and nothing skipped, where fewer are left.
  [[nodiscard]] bool skip(std::size_t size);

 private:
  std::span<const std::uint8_t> bytes_;
};

}  // namespace cairn::spy
