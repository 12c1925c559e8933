// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/geometry.hpp"
#include "mapping/brick_grid.hpp"
#include "mapping/evidence.hpp"
#include "mapping/evidence_plane.hpp"
#include "mapping/grid_index.hpp"

namespace cairn::mapping {

/// Evidence of 512 voxels in the order of index_in_brick, and what the evidence makes of them.
struct alignas(64) EvidenceBrick {
  EvidencePlane occupied_evidence;
  EvidencePlane settled_empty_evidence;     ///< to which pending_empty_evidence is yet to be added
  VoxelMask known;                          ///< free or occupied
  VoxelMask occupied;                       ///< a part of known
  std::uint8_t pending_empty_evidence = 0;  ///< for every voxel
  bool has_hits = false;                    ///< some voxel has occupied evidence
  bool all_free = false;  ///< and none has hits, so that more misses change nothing
  bool dirty = false;     ///< changed since VoxelMap::clear_dirty

  [[nodiscard]] EvidencePlane empty_evidence() const {
    EvidencePlane plane = settled_empty_evidence;
    plane.add(VoxelMask::all(), pending_empty_evidence);
    return plane;
  }
};

struct VoxelState {
  VoxelClass voxel_class = VoxelClass::kUnknown;
  std::uint8_t occupied_evidence = 0;
  std::uint8_t empty_evidence = 0;
};

/// The world as cubes with separate occupied and empty evidence (Ferrese 2012), in the map frame: x
/// and y level, z up.
class VoxelMap {
 public:
  using Grid = BrickGrid<EvidenceBrick>;

  /// resolution_m: side of a voxel, positive.
  explicit VoxelMap(double resolution_m, const EvidenceConfig& config = {});

  [[nodiscard]] double resolution_m() const { return resolution_m_; }
  [[nodiscard]] const Grid& grid() const { return grid_; }

  /// The voxel around a point [m]; the point must be within kVoxelLimit voxels of the origin.
  [[nodiscard]] VoxelIndex voxel_at(const Eigen::Vector3d& point_map) const {
    // std::floor is a call into the C library on processors that the build must suit.
    const auto cell = [this](double coordinate_m) {
      const double voxels = coordinate_m * voxels_per_m_;
      const auto towards_zero = static_cast<std::int32_t>(voxels);
      return towards_zero - (voxels < towards_zero ? 1 : 0);
    };
    return {cell(point_map.x()), cell(point_map.y()), cell(point_map.z())};
  }
  /// Centre of a voxel in the map frame [m].
  [[nodiscard]] Eigen::Vector3d centre_of(VoxelIndex voxel) const;

  [[nodiscard]] VoxelState state(VoxelIndex voxel) const;
  /// Unknown outside the limits, and for a point that is not finite.
  [[nodiscard]] VoxelState state(const Eigen::Vector3d& point_map) const;

  /// Adds `hit_evidence` to the occupied evidence of `hits`, `miss_evidence` to the empty evidence
  /// of `misses` that are not hits; both stop at 255. True if the class of a voxel changed.
  bool add_evidence(BrickIndex brick, const VoxelMask& hits, const VoxelMask& misses,
                    std::uint8_t hit_evidence, std::uint8_t miss_evidence);

  /// Adds `miss_evidence` to the empty evidence of every voxel of a brick, which stops at 255. True
  /// if the class of a voxel changed. Lazy: where all are free already, one number for the brick.
  bool add_free(BrickIndex brick, std::uint8_t miss_evidence);

  /// Replaces all evidence of a brick; 512 values each in the order of index_in_brick.
  void set_evidence(BrickIndex brick, std::span<const std::uint8_t, kBrickVoxels> occupied,
                    std::span<const std::uint8_t, kBrickVoxels> empty);

  [[nodiscard]] std::size_t brick_count() const { return grid_.brick_count(); }
  [[nodiscard]] std::size_t tile_count() const { return grid_.tile_count(); }
  [[nodiscard]] std::size_t known_voxels() const { return known_voxels_; }
  [[nodiscard]] std::size_t occupied_voxels() const { return occupied_voxels_; }
  /// Memory held.
  [[nodiscard]] std::size_t bytes() const;

  /// Bricks whose evidence changed since clear_dirty, sorted by tile and then by index_in_tile.
  [[nodiscard]] std::vector<BrickIndex> dirty_bricks() const;
  void clear_dirty();

 private:
  void mark_dirty(BrickIndex index, EvidenceBrick& brick);
  /// By the evidence of these voxels; the rest stay what they are. True if a class changed.
  bool reclassify(EvidenceBrick& brick, const VoxelMask& voxels);
  static void settle(EvidenceBrick& brick);

  double resolution_m_;
  double voxels_per_m_;
  EvidenceRule rule_;
  Grid grid_;
  std::vector<BrickIndex> dirty_;
  std::size_t known_voxels_ = 0;
  std::size_t occupied_voxels_ = 0;
};

}  // namespace cairn::mapping
