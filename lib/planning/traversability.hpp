// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/config.hpp"
#include "core/robot.hpp"
#include "planning/cell_grid.hpp"
#include "planning/voxel_columns.hpp"

namespace cairn::planning {

struct TraversabilityConfig {
  double step_m = 0.02;
  double max_slope_deg = 12;
  double headroom_m = 0.05;
  int support = 3;

  void visit(ConfigVisitor& v) {
    v.number("step_m", step_m, {0.005, 0.5}, "m",
             "what rises from the floor by more, beyond half a layer of voxels, is in the way");
    v.number("max_slope_deg", max_slope_deg, {0, 30}, "deg", "steeper is no floor");
    v.number("headroom_m", headroom_m, {0, 1}, "m",
             "over the robot's height: what hangs higher is driven under");
    v.integer("support", support, 1, 100, "layers",
              "layers of a column and of its eight neighbours that make it an obstacle");
  }
};

enum class ColumnClass : std::uint8_t {
  kUnknown,   ///< no floor seen, nothing in the way either
  kFree,      ///< floor, and nothing above it as high as the robot
  kOccupied,  ///< something in the way, a step, a drop, too steep
};

/// A disc that is floor though no camera saw it: where the robot stood or drove.
struct KnownFloor {
  Eigen::Vector2d at_m = Eigen::Vector2d::Zero();
  double radius_m = 0;  ///< over half the robot's width: it was put down there, and not all is sure
  double height_m = 0;
};

/// A disc that is in the way though the map does not show it.
struct BlockedSpot {
  Eigen::Vector2d at_m = Eigen::Vector2d::Zero();
  double radius_m = 0;
};

/// The ground as the robot can use it, in the map frame.
struct GroundMap {
  CellBox box;
  std::vector<ColumnClass> classes;
  /// Whether the floor leads there: over floor, and at most kCarry_m over unknown ground. What
  /// lies beyond is unknown.
  std::vector<std::uint8_t> reached;
  std::vector<std::uint8_t>
      assumed;                   ///< free though no camera saw it, nor did the robot drive there
  std::vector<float> floor_m;    ///< height of the floor, or what it would be; where reached
  std::vector<float> ceiling_m;  ///< lowest thing over the floor; infinite if there is none
  /// From the middle of a cell to the nearest occupied column's near side, at least.
  CellGrid<float> to_obstacle_m;

  /// How far over unknown ground the height of the floor is carried on.
  static constexpr double kCarry_m = 0.6;

  [[nodiscard]] ColumnClass at(Cell cell) const {
    return box.contains(cell) ? classes[box.index(cell)] : ColumnClass::kUnknown;
  }
  [[nodiscard]] double clearance_m(Cell cell) const { return to_obstacle_m.at(cell, 0.0F); }
};

/// Judges every column that the floor leads to, growing from the known floor: what is seen within a
/// step of the neighbours' floor, which may rise by the slope, is floor; so a ramp is floor, and a
/// kerb is not. Voxels within a layer of the floor are noise of the floor. Gaps of up to 10 cm in
/// seen floor are floor where rays passed over them.
[[nodiscard]] GroundMap judge_ground(const VoxelColumns& columns, std::span<const KnownFloor> known,
                                     std::span<const BlockedSpot> blocked,
                                     const TraversabilityConfig& config, const RobotConfig& robot);

}  // namespace cairn::planning
