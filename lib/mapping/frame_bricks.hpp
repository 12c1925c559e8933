// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "mapping/brick_table.hpp"
#include "mapping/grid_index.hpp"

namespace cairn::mapping {

/// The voxels of a brick that rays pass through. Rays that run mostly along x, y and z are kept
/// apart, each in layers across their axis, so that a ray marks one word for each layer that it
/// crosses.
struct MissLayers {
  /// [axis][layer]: for axis x bit y + 8 z, for y bit x + 8 z, for z bit x + 8 y.
  std::array<std::array<std::uint64_t, kBrickSide>, 3> words{};

  /// All three in the order of index_in_brick.
  [[nodiscard]] VoxelMask mask() const;
};

/// What the rays of one frame did to a brick.
struct alignas(64) FrameBrick {
  static constexpr std::uint32_t kUnlinked = 0xffffffff;

  MissLayers misses;
  /// Place of the brick across -x +x -y +y -z +z, once somebody asked.
  std::array<std::uint32_t, 6> neighbours{kUnlinked, kUnlinked, kUnlinked,
                                          kUnlinked, kUnlinked, kUnlinked};
  BrickIndex index;
  alignas(64) VoxelMask hits;
};

/// The bricks that one frame's rays cross.
class FrameBricks : public BrickTable<FrameBrick> {
 public:
  /// The brick across a face (numbered as in FrameBrick::neighbours).
  [[nodiscard]] std::uint32_t across(std::uint32_t brick, std::size_t face) {
    const std::uint32_t known = (*this)[brick].neighbours[face];
    return known != FrameBrick::kUnlinked ? known : link(brick, face);
  }

 private:
  [[nodiscard]] std::uint32_t link(std::uint32_t brick, std::size_t face) {
    BrickIndex index = (*this)[brick].index;
    const std::int32_t step = face % 2 == 0 ? -1 : 1;
    (face < 2 ? index.x : face < 4 ? index.y : index.z) += step;
    const std::uint32_t other = find_or_add(index);
    (*this)[brick].neighbours[face] = other;
    (*this)[other].neighbours[face ^ 1] = brick;
    return other;
  }
};

}  // namespace cairn::mapping
