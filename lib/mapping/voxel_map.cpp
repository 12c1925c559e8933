// SPDX-License-Identifier: Apache-2.0
#include "mapping/voxel_map.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <tuple>

namespace cairn::mapping {
namespace {

/// For each byte of mask bits, eight bytes: 0xff where the bit is set. Bit 0 is the first byte in
/// memory.
constexpr auto kBytesOfBits = [] {
  std::array<std::array<std::uint8_t, 8>, 256> table{};
  for (std::size_t bits = 0; bits < 256; ++bits) {
    for (std::size_t i = 0; i < 8; ++i) table[bits][i] = (bits >> i & 1) != 0 ? 0xff : 0;
  }
  return table;
}();

void add_saturating(std::uint8_t* evidence, std::uint64_t voxels, std::uint8_t increment) {
  std::array<std::uint8_t, 64> selected;
  for (std::size_t i = 0; i < 8; ++i) {
    std::memcpy(selected.data() + 8 * i, kBytesOfBits[voxels >> (8 * i) & 0xff].data(), 8);
  }
  for (std::size_t i = 0; i < 64; ++i) {
    const int sum = evidence[i] + (selected[i] & increment);
    evidence[i] = static_cast<std::uint8_t>(sum > 255 ? 255 : sum);
  }
}

}  // namespace

VoxelMap::VoxelMap(double resolution_m, const EvidenceConfig& config)
    : resolution_m_{resolution_m}, voxels_per_m_{1.0 / resolution_m}, rule_{config} {}

VoxelIndex VoxelMap::voxel_at(const Eigen::Vector3d& point_map) const {
  const auto cell = [this](double coordinate_m) {
    return static_cast<std::int32_t>(std::floor(coordinate_m * voxels_per_m_));
  };
  return {cell(point_map.x()), cell(point_map.y()), cell(point_map.z())};
}

Eigen::Vector3d VoxelMap::centre_of(VoxelIndex voxel) const {
  return resolution_m_ * Eigen::Vector3d{voxel.x + 0.5, voxel.y + 0.5, voxel.z + 0.5};
}

VoxelState VoxelMap::state(VoxelIndex voxel) const {
  const EvidenceBrick* brick = grid_.find(brick_of(voxel));
  if (brick == nullptr) return {};
  const int index = index_in_brick(voxel);
  VoxelState state;
  state.occupied_evidence = brick->occupied_evidence[static_cast<std::size_t>(index)];
  state.empty_evidence = brick->empty_evidence[static_cast<std::size_t>(index)];
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
  const VoxelMask known_before = brick.known;
  const VoxelMask occupied_before = brick.occupied;
  for (std::size_t z = 0; z < kBrickSide; ++z) {
    const std::uint64_t hit = hits.words[z];
    const std::uint64_t miss = misses.words[z] & ~hit;
    if (hit != 0) {
      add_saturating(brick.occupied_evidence.data() + 64 * z, hit, hit_evidence);
      brick.words_with_hits = static_cast<std::uint8_t>(brick.words_with_hits | 1U << z);
    }
    if (miss != 0) add_saturating(brick.empty_evidence.data() + 64 * z, miss, miss_evidence);
    // Without occupied evidence a free voxel stays free.
    const bool has_hits = (brick.words_with_hits >> z & 1) != 0;
    reclassify(brick, z, (hit | miss) & (has_hits ? ~std::uint64_t{0} : ~brick.known.words[z]));
  }
  mark_dirty(index, brick);
  if (brick.known == known_before && brick.occupied == occupied_before) return false;
  known_voxels_ += static_cast<std::size_t>(brick.known.count() - known_before.count());
  occupied_voxels_ += static_cast<std::size_t>(brick.occupied.count() - occupied_before.count());
  return true;
}

void VoxelMap::set_evidence(BrickIndex index, std::span<const std::uint8_t, kBrickVoxels> occupied,
                            std::span<const std::uint8_t, kBrickVoxels> empty) {
  EvidenceBrick& brick = grid_.find_or_add(index);
  const int known_before = brick.known.count();
  const int occupied_before = brick.occupied.count();
  std::copy(occupied.begin(), occupied.end(), brick.occupied_evidence.begin());
  std::copy(empty.begin(), empty.end(), brick.empty_evidence.begin());
  brick.words_with_hits = 0;
  for (std::size_t z = 0; z < kBrickSide; ++z) {
    const auto layer = occupied.subspan(64 * z, 64);
    const bool hits = std::any_of(layer.begin(), layer.end(), [](auto value) { return value > 0; });
    brick.words_with_hits =
        static_cast<std::uint8_t>(brick.words_with_hits | (hits ? 1U : 0U) << z);
    reclassify(brick, z, ~std::uint64_t{0});
  }
  mark_dirty(index, brick);
  known_voxels_ += static_cast<std::size_t>(brick.known.count() - known_before);
  occupied_voxels_ += static_cast<std::size_t>(brick.occupied.count() - occupied_before);
}

void VoxelMap::reclassify(EvidenceBrick& brick, std::size_t word, std::uint64_t voxels) const {
  std::uint64_t known = brick.known.words[word] & ~voxels;
  std::uint64_t occupied = brick.occupied.words[word] & ~voxels;
  for (std::uint64_t bits = voxels; bits != 0; bits &= bits - 1) {
    const std::uint64_t bit = bits & (~bits + 1);
    const std::size_t i = 64 * word + static_cast<std::size_t>(std::countr_zero(bits));
    const VoxelClass voxel_class =
        rule_.classify(brick.occupied_evidence[i], brick.empty_evidence[i]);
    known |= voxel_class != VoxelClass::kUnknown ? bit : 0;
    occupied |= voxel_class == VoxelClass::kOccupied ? bit : 0;
  }
  brick.known.words[word] = known;
  brick.occupied.words[word] = occupied;
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
