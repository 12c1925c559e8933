// SPDX-License-Identifier: Apache-2.0
#include "mapping/map_replica.hpp"

#include <algorithm>
#include <cmath>
#include <string>

namespace cairn::mapping {
namespace {

Result<void> check(const MapDelta& delta) {
  if (!std::isfinite(delta.resolution_m) || delta.resolution_m <= 0) {
    return fail("map delta: resolution_m is not positive");
  }
  for (const BrickClasses& brick : delta.bricks) {
    const std::string name = "map delta: brick (" + std::to_string(brick.brick.x) + ", " +
                             std::to_string(brick.brick.y) + ", " + std::to_string(brick.brick.z) +
                             ")";
    if (!within(brick.brick, kBrickLimit)) return fail(name + " is outside the limits");
    if (brick.level != 0) return fail(name + " is of level " + std::to_string(brick.level));
    const bool bad = std::any_of(brick.classes.begin(), brick.classes.end(),
                                 [](std::uint8_t byte) { return (byte & byte >> 1 & 0x55) != 0; });
    if (bad) return fail(name + " has a voxel of class 3");
  }
  return {};
}

/// Bits 0, 2, 4, 6 of a byte, as bits 0 to 3.
std::uint64_t even_bits(std::uint64_t byte) {
  return (byte & 1) | (byte >> 1 & 2) | (byte >> 2 & 4) | (byte >> 3 & 8);
}

void set_classes(const BrickClasses& from, ClassBrick& to) {
  to.known = {};
  to.occupied = {};
  for (std::size_t i = 0; i < from.classes.size(); ++i) {
    const std::uint64_t free = even_bits(from.classes[i]);
    const std::uint64_t occupied = even_bits(from.classes[i] >> 1);
    to.known.words[i / 16] |= (free | occupied) << (4 * (i % 16));
    to.occupied.words[i / 16] |= occupied << (4 * (i % 16));
  }
}

}  // namespace

Result<std::size_t> MapReplica::apply(const MapDelta& delta) {
  const auto checked = check(delta);
  if (!checked) return tl::make_unexpected(checked.error());
  if (delta.map_id != map_id_ || delta.resolution_m != resolution_m_) {
    if (delta.complete_through < utime_) return 0;
    grid_ = Grid{};
    map_id_ = delta.map_id;
    resolution_m_ = delta.resolution_m;
  }
  utime_ = std::max(utime_, delta.complete_through);
  std::size_t taken = 0;
  for (const BrickClasses& classes : delta.bricks) {
    ClassBrick& brick = grid_.find_or_add(classes.brick);
    if (delta.complete_through < brick.utime) continue;
    set_classes(classes, brick);
    brick.utime = delta.complete_through;
    ++taken;
  }
  return taken;
}

VoxelClass MapReplica::voxel_class(VoxelIndex voxel) const {
  const ClassBrick* brick = grid_.find(brick_of(voxel));
  const int index = index_in_brick(voxel);
  if (brick == nullptr || !brick->known.test(index)) return VoxelClass::kUnknown;
  return brick->occupied.test(index) ? VoxelClass::kOccupied : VoxelClass::kFree;
}

}  // namespace cairn::mapping
