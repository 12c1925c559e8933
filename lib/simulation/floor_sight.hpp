// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include "camera/rig_calibration.hpp"
#include "core/geometry.hpp"
#include "core/result.hpp"
#include "core/robot.hpp"
#include "simulation/eye.hpp"
#include "simulation/ray_scene.hpp"
#include "simulation/reachable_floor.hpp"
#include "simulation/world.hpp"

namespace cairn::simulation {

struct FloorSightConfig {
  double max_range_m = 4;    ///< depth along the left camera's axis
  double every_m = 0.1;      ///< looks again after so much way
  double every_rad = 0.175;  ///< or so much turn
};

/// Counts how much of the reachable floor a robot has seen: the truth behind `coverage` in a
/// report. A cell counts once its middle was in the left camera's picture, within the range and
/// with nothing before it, or under the robot's body. (Of a bent lens the largest upright rectangle
/// of view is taken.) People do not hide the floor here.
class FloorSight {
 public:
  [[nodiscard]] static Result<FloorSight> create(const World& world,
                                                 const camera::RigCalibration& rig,
                                                 const RobotConfig& robot, ReachableFloor floor,
                                                 const FloorSightConfig& config);

  /// Cheap for poses near the one before: those only count as driven over.
  void look(const Isometry& T_world_body);

  [[nodiscard]] const ReachableFloor& floor() const { return floor_; }
  /// Of each of floor().cells(): 1 once seen.
  [[nodiscard]] const std::vector<std::uint8_t>& seen() const { return seen_; }
  /// In [0, 1].
  [[nodiscard]] double share() const;

 private:
  FloorSight(RayScene scene, const RobotConfig& robot, ReachableFloor floor,
             const FloorSightConfig& config);
  void stand_on(const Isometry& T_world_body);
  void look_from(const Isometry& T_world_eye);
  void count(std::size_t cell);

  RayScene scene_;
  Isometry T_body_eye_ = Isometry::Identity();
  Eigen::AlignedBox2d view_;  ///< of (x, y) of the rays (x, y, 1)
  Eigen::Vector2d half_body_m_;
  ReachableFloor floor_;
  FloorSightConfig config_;
  std::vector<std::uint8_t> seen_;
  std::size_t count_ = 0;
  std::optional<Isometry> T_world_last_;
};

}  // namespace cairn::simulation
