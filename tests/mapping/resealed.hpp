// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

#include "core/checksum.hpp"

namespace cairn::mapping::testing {

using Bytes = std::vector<std::uint8_t>;

template <class T>
T number_at(const Bytes& bytes, std::size_t at) {
  T value{};
  if (at + sizeof(T) <= bytes.size()) std::memcpy(&value, bytes.data() + at, sizeof(T));
  return value;
}

template <class T>
void put_number_at(Bytes& bytes, std::size_t at, T value) {
  if (at + sizeof(T) <= bytes.size()) std::memcpy(bytes.data() + at, &value, sizeof(T));
}

inline std::uint64_t checksum_of(const Bytes& bytes, std::size_t first, std::size_t last,
                                 std::uint64_t seed = fnv1a_64({})) {
  return fnv1a_64(std::span{bytes}.subspan(first, last - first), seed);
}

/// The file with every checksum made to match what it covers, as far as its sizes can be followed:
/// what a forger would hand in. Written from the format's description alone.
inline Bytes resealed_map(Bytes bytes) {
  constexpr std::size_t kHeader = 52;
  constexpr std::size_t kTileHead = 20;
  if (bytes.size() < kHeader + 16) return bytes;
  put_number_at(bytes, kHeader, checksum_of(bytes, 0, kHeader));
  Bytes sums(bytes.begin() + kHeader, bytes.begin() + kHeader + 8);
  std::size_t at = kHeader + 8;
  while (at + kTileHead + 8 + 8 < bytes.size()) {
    const std::size_t payload = number_at<std::uint32_t>(bytes, at + 16);
    const std::size_t start = at + kTileHead + 8;
    if (payload > bytes.size() - start) break;
    const std::uint64_t head = checksum_of(bytes, at, at + kTileHead);
    put_number_at(bytes, at + kTileHead, checksum_of(bytes, start, start + payload, head));
    sums.insert(sums.end(), bytes.begin() + static_cast<std::ptrdiff_t>(at + kTileHead),
                bytes.begin() + static_cast<std::ptrdiff_t>(start));
    at = start + payload;
  }
  put_number_at(bytes, bytes.size() - 8, checksum_of(sums, 0, sums.size()));
  return bytes;
}

}  // namespace cairn::mapping::testing
