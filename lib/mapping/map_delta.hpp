// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/time.hpp"
#include "mapping/grid_index.hpp"
#include "mapping/voxel_map.hpp"

namespace cairn::mapping {

/// The classes of one brick's voxels, two bits each (VoxelClass) in the order of index_in_brick:
/// voxel i is bits 2 (i % 4) and up of byte i / 4.
struct BrickClasses {
  BrickIndex brick;
  std::uint8_t level = 0;  ///< a voxel's side is resolution * 2^level
  std::array<std::uint8_t, kBrickVoxels / 4> classes{};

  [[nodiscard]] VoxelClass at(int index) const {
    return static_cast<VoxelClass>(
        classes[static_cast<std::size_t>(index / 4)] >> (2 * (index % 4)) & 3);
  }
  friend bool operator==(const BrickClasses&, const BrickClasses&) = default;
};

/// What a map's readers are told: the present classes of the bricks in which a class changed.
struct MapDelta {
  std::uint64_t map_id = 0;
  Utime complete_through = 0;  ///< every frame up to this one is in
  double resolution_m = 0;
  std::vector<BrickClasses> bricks;
};

/// The classes that these masks say; `occupied` is a part of `known`.
[[nodiscard]] BrickClasses classes_of(BrickIndex brick, const VoxelMask& known,
                                      const VoxelMask& occupied);

/// All unknown where the map has no such brick.
[[nodiscard]] BrickClasses classes_of(const VoxelMap& map, BrickIndex brick);

/// The present classes of these bricks.
[[nodiscard]] MapDelta make_delta(const VoxelMap& map, std::uint64_t map_id, Utime complete_through,
                                  std::span<const BrickIndex> bricks);

}  // namespace cairn::mapping
