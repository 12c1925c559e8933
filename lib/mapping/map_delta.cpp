// SPDX-License-Identifier: Apache-2.0
#include "mapping/map_delta.hpp"

namespace cairn::mapping {
namespace {

/// Bit i of the lower half becomes bit 2 i.
std::uint64_t spread(std::uint64_t bits) {
  bits &= 0xffffffff;
  bits = (bits | bits << 16) & 0x0000ffff0000ffffULL;
  bits = (bits | bits << 8) & 0x00ff00ff00ff00ffULL;
  bits = (bits | bits << 4) & 0x0f0f0f0f0f0f0f0fULL;
  bits = (bits | bits << 2) & 0x3333333333333333ULL;
  return (bits | bits << 1) & 0x5555555555555555ULL;
}

}  // namespace

BrickClasses classes_of(BrickIndex index, const VoxelMask& known, const VoxelMask& occupied) {
  BrickClasses result;
  result.brick = index;
  for (std::size_t half = 0; half < 16; ++half) {
    const std::size_t shift = 32 * (half % 2);
    const std::uint64_t free = known.words[half / 2] & ~occupied.words[half / 2];
    const std::uint64_t classes = spread(free >> shift) | spread(occupied.words[half / 2] >> shift)
                                                              << 1;
    for (std::size_t i = 0; i < 8; ++i) {
      result.classes[8 * half + i] = static_cast<std::uint8_t>(classes >> (8 * i));
    }
  }
  return result;
}

BrickClasses classes_of(const VoxelMap& map, BrickIndex index) {
  const EvidenceBrick* brick = map.grid().find(index);
  return brick == nullptr ? BrickClasses{index, 0, {}}
                          : classes_of(index, brick->known, brick->occupied);
}

MapDelta make_delta(const VoxelMap& map, std::uint64_t map_id, Utime complete_through,
                    std::span<const BrickIndex> bricks) {
  MapDelta delta{map_id, complete_through, map.resolution_m(), {}};
  delta.bricks.reserve(bricks.size());
  for (const BrickIndex brick : bricks) delta.bricks.push_back(classes_of(map, brick));
  return delta;
}

}  // namespace cairn::mapping
