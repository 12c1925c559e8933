// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

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
  MissLayers misses;
  std::array<std::uint32_t, 6> neighbours;  ///< place of the brick across -x +x -y +y -z +z
  BrickIndex index;
  alignas(64) VoxelMask hits;
};

/// The bricks that one frame's rays cross. A brick is named by its place, which is good until
/// clear().
class FrameBricks {
 public:
  FrameBricks() { clear(); }

  void clear() {
    bricks_.clear();
    table_.assign(kTableSize > table_.size() ? kTableSize : table_.size(), kNone);
  }

  [[nodiscard]] std::uint32_t find_or_add(BrickIndex index) {
    std::size_t at = place(index);
    if (table_[at] == kNone) {
      if (2 * (bricks_.size() + 1) > table_.size()) {
        grow_table();
        at = place(index);
      }
      table_[at] = static_cast<std::uint32_t>(bricks_.size());
      bricks_.push_back({{}, {kNone, kNone, kNone, kNone, kNone, kNone}, index, {}});
    }
    return table_[at];
  }

  /// The brick across a face (numbered as in FrameBrick::neighbours).
  [[nodiscard]] std::uint32_t across(std::uint32_t brick, std::size_t face) {
    const std::uint32_t known = (*this)[brick].neighbours[face];
    return known != kNone ? known : link(brick, face);
  }

  [[nodiscard]] FrameBrick& operator[](std::uint32_t brick) { return bricks_.data()[brick]; }
  [[nodiscard]] const std::vector<FrameBrick>& all() const { return bricks_; }

 private:
  static constexpr std::uint32_t kNone = 0xffffffff;
  static constexpr std::size_t kTableSize = 1024;

  [[nodiscard]] std::uint32_t link(std::uint32_t brick, std::size_t face) {
    BrickIndex index = bricks_[brick].index;
    const std::int32_t step = face % 2 == 0 ? -1 : 1;
    (face < 2 ? index.x : face < 4 ? index.y : index.z) += step;
    const std::uint32_t other = find_or_add(index);
    bricks_[brick].neighbours[face] = other;
    bricks_[other].neighbours[face ^ 1] = brick;
    return other;
  }

  [[nodiscard]] std::size_t place(BrickIndex index) const {
    constexpr std::uint64_t kGoldenRatio = 0x9e3779b97f4a7c15ULL;
    const std::size_t last = table_.size() - 1;
    std::size_t at = (packed(index) * kGoldenRatio) >> (64 - std::bit_width(last));
    while (table_[at] != kNone && bricks_[table_[at]].index != index) at = (at + 1) & last;
    return at;
  }

  void grow_table() {
    table_.assign(table_.size() * 2, kNone);
    for (std::size_t i = 0; i < bricks_.size(); ++i) {
      table_[place(bricks_[i].index)] = static_cast<std::uint32_t>(i);
    }
  }

  std::vector<FrameBrick> bricks_;
  std::vector<std::uint32_t> table_;
};

}  // namespace cairn::mapping
