// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <limits>

#include "core/result.hpp"
#include "core/time.hpp"
#include "mapping/brick_grid.hpp"
#include "mapping/map_delta.hpp"

namespace cairn::mapping {

struct ClassBrick {
  VoxelMask known;                                  ///< free or occupied
  VoxelMask occupied;                               ///< a part of known
  Utime utime = std::numeric_limits<Utime>::min();  ///< of the delta that this is from
};

/// A reader's copy of the map's classes, kept by deltas. A delta may come twice, late, or in parts:
/// for each brick the newest one stands.
class MapReplica {
 public:
  using Grid = BrickGrid<ClassBrick>;

  /// Takes what is news in a delta; gives the number of bricks taken. A newer delta of another map,
  /// or of another resolution, begins a new copy; an older one of another map is passed over.
  /// Refused, with nothing changed: a voxel class of 3, a brick outside the limits, a level over 0,
  /// a resolution that is not positive.
  [[nodiscard]] Result<std::size_t> apply(const MapDelta& delta);

  /// 0 before the first delta.
  [[nodiscard]] std::uint64_t map_id() const { return map_id_; }
  [[nodiscard]] double resolution_m() const { return resolution_m_; }
  /// Of the newest delta taken.
  [[nodiscard]] Utime utime() const { return utime_; }
  [[nodiscard]] const Grid& grid() const { return grid_; }
  [[nodiscard]] VoxelClass voxel_class(VoxelIndex voxel) const;

 private:
  Grid grid_;
  std::uint64_t map_id_ = 0;
  double resolution_m_ = 0;
  Utime utime_ = std::numeric_limits<Utime>::min();
};

}  // namespace cairn::mapping
