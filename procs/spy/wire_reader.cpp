// SPDX-License-Identifier: Apache-2.0
#include "procs/spy/wire_reader.hpp"

namespace cairn::spy {

bool WireReader::skip(std::size_t size) {
  if (size > bytes_.size()) return false;
  bytes_ = bytes_.subspan(size);
  return true;
}

std::optional<std::uint64_t> WireReader::unsigned_integer(std::size_t size) {
  const auto from = bytes_;
  if (!skip(size)) return std::nullopt;
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < size; ++i) value = value << 8 | from[i];
  return value;
}

std::optional<std::int64_t> WireReader::signed_integer(std::size_t size) {
  const auto value = unsigned_integer(size);
  if (!value) return std::nullopt;
  const auto unused_bits = static_cast<int>(64 - 8 * size);
  return static_cast<std::int64_t>(*value << unused_bits) >> unused_bits;
}

std::optional<std::string_view> WireReader::text() {
  const auto size = signed_integer(4);
  if (!size || *size < 1) return std::nullopt;
  const auto from = bytes_;
  if (!skip(static_cast<std::size_t>(*size))) return std::nullopt;
  return std::string_view(reinterpret_cast<const char*>(from.data()),
                          static_cast<std::size_t>(*size) - 1);
}

}  // namespace cairn::spy
