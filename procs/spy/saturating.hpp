// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <limits>

namespace cairn::spy {

/// a + b; at the end of the range where that lies beyond. For numbers out of messages and
/// recordings, which may be anything.
[[nodiscard]] constexpr std::int64_t saturating_sum(std::int64_t a, std::int64_t b) {
  std::int64_t sum = 0;
  if (!__builtin_add_overflow(a, b, &sum)) return sum;
  return a < 0 ? std::numeric_limits<std::int64_t>::min()
               : std::numeric_limits<std::int64_t>::max();
}

/// a - b, likewise.
[[nodiscard]] constexpr std::int64_t saturating_difference(std::int64_t a, std::int64_t b) {
  std::int64_t difference = 0;
  if (!__builtin_sub_overflow(a, b, &difference)) return difference;
  return a < 0 ? std::numeric_limits<std::int64_t>::min()
               : std::numeric_limits<std::int64_t>::max();
}

/// How long ago `then` was; 0 where it is yet to come.
[[nodiscard]] constexpr std::int64_t age(std::int64_t now, std::int64_t then) {
  const std::int64_t difference = saturating_difference(now, then);
  return difference > 0 ? difference : 0;
}

}  // namespace cairn::spy
