// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <deque>
#include <span>

#include "core/robot.hpp"
#include "core/time.hpp"
#include "mapping/map_replica.hpp"
#include "planning/path_search.hpp"
#include "planning/traversability.hpp"
#include "planning/voxel_columns.hpp"

namespace cairn::planning {

/// Keeps the ground up with the map, a bounded amount of work at a time.
class GroundModel {
 public:
  static constexpr std::size_t kBricksPerStep = 3000;
  static constexpr std::int64_t kPeriod_us = 250'000;

  GroundModel(const TraversabilityConfig& ground, const RouteConfig& routes,
              const RobotConfig& robot)
      : config_{ground}, route_config_{routes}, robot_{robot} {}

  /// What changed in the map.
  void take(const mapping::MapReplica::Changes& changes);
  /// Reads the next of what changed.
  void read(const mapping::MapReplica& map);

  /// Judges the ground anew if that is due: something changed, and the last time is kPeriod_us
  /// ago. True if it did.
  bool refresh(Utime now, std::span<const KnownFloor> known, std::span<const BlockedSpot> blocked);
  /// Makes it due: known floor or blocked spots changed.
  void renew() { changed_ = true; }

  [[nodiscard]] const GroundMap& ground() const { return ground_; }
  [[nodiscard]] const CostGrid& costs() const { return costs_; }
  /// When the ground was judged last.
  [[nodiscard]] Utime judged() const { return judged_; }

 private:
  TraversabilityConfig config_;
  RouteConfig route_config_;
  RobotConfig robot_;
  VoxelColumns columns_;
  std::deque<mapping::BrickIndex> waiting_;
  GroundMap ground_;
  CostGrid costs_;
  Utime judged_ = 0;
  bool changed_ = true;
};

}  // namespace cairn::planning
