// SPDX-License-Identifier: Apache-2.0
#include "mapping/map_replica.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

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
  for (std::size_t i = 0; i < from.classes.size(); ++i) {
    const std::uint64_t free = even_bits(from.classes[i]);
    const std::uint64_t occupied = even_bits(from.classes[i] >> 1);
    to.known.words[i / 16] |= (free | occupied) << (4 * (i % 16));
    to.occupied.words[i / 16] |= occupied << (4 * (i % 16));
  }
}

/// Finaliser of SplitMix64 (Steele, Lea and Flood 2014).
std::uint64_t scattered(std::uint64_t x) {
  x = (x ^ x >> 30) * 0xbf58476d1ce4e5b9ULL;
  x = (x ^ x >> 27) * 0x94d049bb133111ebULL;
  return x ^ x >> 31;
}

/// A brick's share in its tile's hash; 0 if nothing in it is known.
std::uint64_t hash_of(BrickIndex index, const ClassBrick& brick) {
  if (!brick.known.any()) return 0;
  auto hash = static_cast<std::uint64_t>(index_in_tile(index)) + 1;
  for (const VoxelMask* mask : {&brick.known, &brick.occupied}) {
    for (const std::uint64_t word : mask->words) hash = scattered(hash ^ word) + word;
  }
  return scattered(hash);
}

}  // namespace

Result<std::size_t> MapReplica::apply(const MapDelta& delta) {
  const auto checked = check(delta);
  if (!checked) return tl::make_unexpected(checked.error());
  if (delta.map_id != map_id_ || delta.resolution_m != resolution_m_) {
    if (delta.complete_through < utime_) return 0;
    start_over(delta);
  }
  utime_ = std::max(utime_, delta.complete_through);
  std::size_t taken = 0;
  for (const BrickClasses& classes : delta.bricks) {
    const ClassBrick* brick = grid_.find(classes.brick);
    if (brick != nullptr && delta.complete_through < brick->utime) continue;
    if (brick != nullptr || classes != BrickClasses{classes.brick, 0, {}}) {
      take(classes, delta.complete_through);
    }
    ++taken;
  }
  return taken;
}

void MapReplica::start_over(const MapDelta& delta) {
  grid_ = Grid{};
  tile_states_.clear();
  changes_ = Changes{true, {}};
  map_id_ = delta.map_id;
  resolution_m_ = delta.resolution_m;
}

void MapReplica::take(const BrickClasses& from, Utime utime) {
  ClassBrick& brick = grid_.find_or_add(from.brick);
  ClassBrick news;
  set_classes(from, news);
  brick.utime = utime;
  TileState& tile = tile_states_[tile_of(from.brick)];
  tile.utime = std::max(tile.utime, utime);
  if (news.known == brick.known && news.occupied == brick.occupied) return;
  tile.hash += hash_of(from.brick, news) - hash_of(from.brick, brick);
  brick.known = news.known;
  brick.occupied = news.occupied;
  if (!brick.changed) changes_.bricks.push_back(from.brick);
  brick.changed = true;
}

MapReplica::TileState MapReplica::tile_state(TileIndex tile) const {
  const auto found = tile_states_.find(tile);
  return found == tile_states_.end() ? TileState{} : found->second;
}

MapReplica::Changes MapReplica::take_changes() {
  Changes taken = std::move(changes_);
  changes_ = {};
  std::sort(taken.bricks.begin(), taken.bricks.end());
  for (const BrickIndex brick : taken.bricks) grid_.find(brick)->changed = false;
  return taken;
}

VoxelClass MapReplica::voxel_class(VoxelIndex voxel) const {
  const ClassBrick* brick = grid_.find(brick_of(voxel));
  const int index = index_in_brick(voxel);
  if (brick == nullptr || !brick->known.test(index)) return VoxelClass::kUnknown;
  return brick->occupied.test(index) ? VoxelClass::kOccupied : VoxelClass::kFree;
}

BrickClasses classes_of(const MapReplica& map, BrickIndex index) {
  const ClassBrick* brick = map.grid().find(index);
  return brick == nullptr ? BrickClasses{index, 0, {}}
                          : classes_of(index, brick->known, brick->occupied);
}

}  // namespace cairn::mapping
