// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>

namespace cairn {

/// 64-bit FNV-1a (Fowler, Noll, Vo 1991): tells whole bytes from damaged ones, and one content from
/// another. Not for security.
[[nodiscard]] constexpr std::uint64_t fnv1a_64(std::span<const std::uint8_t> bytes,
                                               std::uint64_t seed = 0xcbf29ce484222325ULL) {
  for (const std::uint8_t byte : bytes) seed = (seed ^ byte) * 0x100000001b3ULL;
  return seed;
}

}  // namespace cairn
