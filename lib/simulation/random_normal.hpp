// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>

#include "simulation/random_hash.hpp"

namespace cairn::simulation {

/// Of mean 0 and deviation 1 (Box and Muller 1958).
[[nodiscard]] inline double normal_random(std::uint64_t hash) {
  const double radius = std::sqrt(-2 * std::log(1 - unit_random(hash64(hash, 1))));
  return radius * std::cos(2 * std::numbers::pi * unit_random(hash64(hash, 2)));
}

}  // namespace cairn::simulation
