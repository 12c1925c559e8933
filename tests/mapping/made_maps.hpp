// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <random>

#include "mapping/voxel_map.hpp"

namespace cairn::mapping::testing {

inline VoxelMask random_mask(std::mt19937& random, double share) {
  VoxelMask mask;
  std::bernoulli_distribution set{share};
  for (int i = 0; i < kBrickVoxels; ++i) {
    if (set(random)) mask.set(i);
  }
  return mask;
}

/// A brick at most `reach` bricks from the origin on each axis.
inline BrickIndex random_brick(std::mt19937& random, std::int32_t reach) {
  std::uniform_int_distribution<std::int32_t> at{-reach, reach};
  const std::int32_t x = at(random);
  const std::int32_t y = at(random);
  return {x, y, at(random)};
}

inline void add_random_evidence(VoxelMap& map, std::mt19937& random, int bricks,
                                std::int32_t reach) {
  for (int i = 0; i < bricks; ++i) {
    const BrickIndex brick = random_brick(random, reach);
    const VoxelMask hits = random_mask(random, 0.05);
    map.add_evidence(brick, hits, random_mask(random, 0.4), 9, 3);
  }
}

inline VoxelMap random_map(unsigned seed, int bricks, std::int32_t reach = 20) {
  std::mt19937 random{seed};
  VoxelMap map{0.05};
  add_random_evidence(map, random, bricks, reach);
  return map;
}

}  // namespace cairn::mapping::testing
