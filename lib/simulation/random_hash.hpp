// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace cairn::simulation {

/// A well-mixed 64-bit number of a number: counted random numbers without a state (splitmix64,
/// Steele, Lea, Flood 2014).
[[nodiscard]] constexpr std::uint64_t hash64(std::uint64_t value) {
  value += 0x9e3779b97f4a7c15ULL;
  value = (value ^ (value >> 30)) * 0xbf58476d1ce4e5b9ULL;
  value = (value ^ (value >> 27)) * 0x94d049bb133111ebULL;
  return value ^ (value >> 31);
}

/// One seed out of two.
[[nodiscard]] constexpr std::uint64_t hash64(std::uint64_t a, std::uint64_t b) {
  return hash64(hash64(a) ^ b);
}

/// In [0, 1).
[[nodiscard]] constexpr double unit_random(std::uint64_t hash) {
  return static_cast<double>(hash >> 11) * 0x1.0p-53;
}

}  // namespace cairn::simulation
