// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <limits>
#include <map>
#include <vector>

#include "core/result.hpp"
#include "core/time.hpp"
#include "mapping/brick_grid.hpp"
#include "mapping/map_delta.hpp"

namespace cairn::mapping {

struct ClassBrick {
  VoxelMask known;                                  ///< free or occupied
  VoxelMask occupied;                               ///< a part of known
  Utime utime = std::numeric_limits<Utime>::min();  ///< of the delta that this is from
  bool changed = false;                             ///< since MapReplica::take_changes
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

  /// What a tile's voxels are, as one number: equal in two copies if and only if (but for one
  /// chance in 2^64) all voxels are. 0 where all are unknown.
  struct TileState {
    std::uint64_t hash = 0;
    Utime utime = std::numeric_limits<Utime>::min();  ///< of the newest delta with a brick of it
  };
  [[nodiscard]] TileState tile_state(TileIndex tile) const;
  [[nodiscard]] const std::map<TileIndex, TileState>& tile_states() const { return tile_states_; }

  /// What became different.
  struct Changes {
    bool started_over = false;       ///< the copy is a new one: nothing seen before holds
    std::vector<BrickIndex> bricks;  ///< in which a voxel is of another class; sorted, each once
  };
  /// Since it was last asked.
  [[nodiscard]] Changes take_changes();

 private:
  void start_over(const MapDelta& delta);
  void take(const BrickClasses& from, Utime utime);

  Grid grid_;
  std::uint64_t map_id_ = 0;
  double resolution_m_ = 0;
  Utime utime_ = std::numeric_limits<Utime>::min();
  std::map<TileIndex, TileState> tile_states_;
  Changes changes_;
};

/// All unknown where the copy has no such brick.
[[nodiscard]] BrickClasses classes_of(const MapReplica& map, BrickIndex brick);

}  // namespace cairn::mapping
