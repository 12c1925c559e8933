// SPDX-License-Identifier: Apache-2.0
#include "mapping/voxel_map.hpp"

#include <algorithm>
#include <bit>
#include <tuple>

namespace cairn::mapping {
VoxelMap::VoxelMap(double resolution_m, const EvidenceConfig& config)
    : resolution_m_{resolution_m}, voxels_per_m_{1.0 / resolution_m}, rule_{config} {}

Eigen::Vector3d VoxelMap::centre_of(VoxelIndex voxel) const {
  return resolution_m_ * Eigen::Vector3d{voxel.x + 0.5, voxel.y + 0.5, voxel.z + 0.5};
}

VoxelState VoxelMap::state(VoxelIndex voxel) const {
  const EvidenceBrick* brick = grid_.find(brick_of(voxel));
  if (brick == nullptr) return {};
  const int index = index_in_brick(voxel);
  VoxelState state;
  const auto i = static_cast<std::size_t>(index);
  state.occupied_evidence = brick->occupied_evidence.of[i];
  state.empty_evidence = static_cast<std::uint8_t>(
      std::min(255, brick->settled_empty_evidence.of[i] + brick->pending_empty_evidence));
  if (brick->known.test(index)) {
    state.voxel_class = brick->occupied.test(index) ? VoxelClass::kOccupied : VoxelClass::kFree;
  }
  return state;
}

VoxelState VoxelMap::state(const Eigen::Vector3d& point_map) const {
  const double limit_m = (kVoxelLimit - 1) * resolution_m_;
  if (!point_map.allFinite() || point_map.cwiseAbs().maxCoeff() > limit_m) return {};
  return state(voxel_at(point_map));
}

bool VoxelMap::add_evidence(BrickIndex index, const VoxelMask& hits, const VoxelMask& misses,
                            std::uint8_t hit_evidence, std::uint8_t miss_evidence) {
  EvidenceBrick& brick = grid_.find_or_add(index);
  settle(brick);
  VoxelMask touched = hits;
  VoxelMask only_passed = misses;
  for (std::size_t z = 0; z < kBrickSide; ++z) {
    only_passed.words[z] &= ~hits.words[z];
    touched.words[z] |= misses.words[z];
  }
  if (hits.any()) {
    brick.occupied_evidence.add(hits, hit_evidence);
    brick.has_hits = true;
  }
  brick.settled_empty_evidence.add(only_passed, miss_evidence);
  mark_dirty(index, brick);
  return reclassify(brick, touched);
}

bool VoxelMap::add_free(BrickIndex index, std::uint8_t miss_evidence) {
  EvidenceBrick& brick = grid_.find_or_add(index);
  if (!brick.all_free) return add_evidence(index, {}, VoxelMask::all(), 0, miss_evidence);
  const int sum = std::min(255, brick.pending_empty_evidence + miss_evidence);
  if (sum != brick.pending_empty_evidence) mark_dirty(index, brick);
  brick.pending_empty_evidence = static_cast<std::uint8_t>(sum);
  return false;
}

void VoxelMap::settle(EvidenceBrick& brick) {
  if (brick.pending_empty_evidence == 0) return;
  brick.settled_empty_evidence = brick.empty_evidence();
  brick.pending_empty_evidence = 0;
}

void VoxelMap::set_evidence(BrickIndex index, std::span<const std::uint8_t, kBrickVoxels> occupied,
                            std::span<const std::uint8_t, kBrickVoxels> empty) {
  EvidenceBrick& brick = grid_.find_or_add(index);
  std::copy(occupied.begin(), occupied.end(), brick.occupied_evidence.of.begin());
  std::copy(empty.begin(), empty.end(), brick.settled_empty_evidence.of.begin());
  brick.pending_empty_evidence = 0;
  brick.has_hits = brick.occupied_evidence.at_least(1).any();
  mark_dirty(index, brick);
  reclassify(brick, VoxelMask::all());
}

bool VoxelMap::reclassify(EvidenceBrick& brick, const VoxelMask& voxels) {
  const VoxelMask known_before = brick.known;
  const VoxelMask occupied_before = brick.occupied;
  const VoxelMask free_unless_hit = brick.settled_empty_evidence.at_least(rule_.free_from());
  const VoxelMask hit = brick.has_hits ? brick.occupied_evidence.at_least(1) : VoxelMask{};
  for (std::size_t z = 0; z < kBrickSide; ++z) {
    const std::uint64_t never_hit = voxels.words[z] & ~hit.words[z];
    brick.known.words[z] =
        (brick.known.words[z] & ~never_hit) | (free_unless_hit.words[z] & never_hit);
    brick.occupied.words[z] &= ~never_hit;
    for (std::uint64_t bits = voxels.words[z] & hit.words[z]; bits != 0; bits &= bits - 1) {
      const std::uint64_t bit = bits & (~bits + 1);
      const std::size_t i = 64 * z + static_cast<std::size_t>(std::countr_zero(bits));
      const VoxelClass voxel_class =
          rule_.classify(brick.occupied_evidence.of[i], brick.settled_empty_evidence.of[i]);
      brick.known.words[z] &= ~bit;
      brick.occupied.words[z] &= ~bit;
      if (voxel_class != VoxelClass::kUnknown) brick.known.words[z] |= bit;
      if (voxel_class == VoxelClass::kOccupied) brick.occupied.words[z] |= bit;
    }
  }
  brick.all_free = !brick.has_hits && brick.known == VoxelMask::all();
  if (brick.known == known_before && brick.occupied == occupied_before) return false;
  known_voxels_ += static_cast<std::size_t>(brick.known.count() - known_before.count());
  occupied_voxels_ += static_cast<std::size_t>(brick.occupied.count() - occupied_before.count());
  return true;
}

void VoxelMap::mark_dirty(BrickIndex index, EvidenceBrick& brick) {
  if (!brick.dirty) dirty_.push_back(index);
  brick.dirty = true;
}

std::vector<BrickIndex> VoxelMap::dirty_bricks() const {
  std::vector<BrickIndex> sorted = dirty_;
  std::sort(sorted.begin(), sorted.end(), [](BrickIndex a, BrickIndex b) {
    return std::tuple{tile_of(a), index_in_tile(a)} < std::tuple{tile_of(b), index_in_tile(b)};
  });
  return sorted;
}

void VoxelMap::clear_dirty() {
  for (const BrickIndex index : dirty_) grid_.find(index)->dirty = false;
  dirty_.clear();
}

std::size_t VoxelMap::bytes() const {
  return grid_.bytes() + dirty_.capacity() * sizeof(BrickIndex);
}

}  // namespace cairn::mapping
