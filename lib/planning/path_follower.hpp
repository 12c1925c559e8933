// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "core/config.hpp"
#include "core/robot.hpp"
#include "planning/pose2.hpp"

namespace cairn::planning {

struct FollowerConfig {
  double least_look_ahead_m = 0.22;
  double most_look_ahead_m = 0.6;
  double look_ahead_s = 1;
  double arrived_m = 0.06;
  double arrived_deg = 5;
  double turn_on_spot_deg = 75;
  double turn_radps = 1.0;
  double braking_mps2 = 0.4;
  double turn_acceleration_radps2 = 2.5;

  void visit(ConfigVisitor& v) {
    v.number("least_look_ahead_m", least_look_ahead_m, {0.05, 5}, "m",
             "the point that is steered for lies this far ahead at least");
    v.number("most_look_ahead_m", most_look_ahead_m, {0.05, 5}, "m", "and at most");
    v.number("look_ahead_s", look_ahead_s, {0.1, 10}, "s", "and by speed, between these");
    v.number("arrived_m", arrived_m, {0.01, 1}, "m", "how near the end counts as there");
    v.number("arrived_deg", arrived_deg, {0.5, 90}, "deg", "how well the heading there must fit");
    v.number("turn_on_spot_deg", turn_on_spot_deg, {20, 180}, "deg",
             "what lies farther to the side is turned to on the spot");
    v.number("turn_radps", turn_radps, {0.05, 10}, "rad/s", "of turns on the spot");
    v.number("braking_mps2", braking_mps2, {0.05, 10}, "m/s^2", "towards the end of the path");
    v.number("turn_acceleration_radps2", turn_acceleration_radps2, {0.1, 50}, "rad/s^2",
             "of turns");
  }
};

/// A point of a path, in the odometry frame.
struct PathPoint {
  Eigen::Vector2d at_m = Eigen::Vector2d::Zero();
  double speed_mps = 0;  ///< fastest there
  double room_m = 0;     ///< how far the robot may stray from it
};

struct PlannedPath {
  std::vector<PathPoint> points;
  std::optional<double> heading_rad;  ///< wanted at its end
};

/// How to move now.
struct Drive {
  double forward_mps = 0;
  double turn_radps = 0;
};

/// What is allowed now.
struct DriveLimits {
  double forward_mps = 0;  ///< by guard
  double turn_radps = 0;   ///< on the spot
};

/// Follows a path by regulated pure pursuit (Coulter 1992; Macenski et al. 2023): slower in curves,
/// where there is little room, and towards the end; on the spot where the path leads far to the
/// side. The look-ahead is no longer than the room allows, so corners are not cut.
class PathFollower {
 public:
  PathFollower(const FollowerConfig& config, const RobotConfig& robot)
      : config_{config}, robot_{robot} {}

  /// Takes a new path, at the speed that the robot has.
  void follow(PlannedPath path);
  void drop();
  [[nodiscard]] bool following() const { return !path_.points.empty(); }

  /// One control step; `moving` is what was commanded before, dt_s ago. What may not go forward
  /// turns to where the path leads.
  [[nodiscard]] Drive step(const Pose2& robot, const Drive& moving, double dt_s,
                           const DriveLimits& allowed);

  /// A step of a turn on the spot by the angle that is left.
  [[nodiscard]] Drive turn(double left_rad, const Drive& moving, double dt_s,
                           double most_radps) const;
  /// Coming to a stand.
  [[nodiscard]] Drive halt(const Drive& moving, double dt_s) const;

  /// At the end, heading included.
  [[nodiscard]] bool arrived() const { return arrived_; }
  /// Along the path.
  [[nodiscard]] double distance_left_m() const;
  /// From the path, at the last step.
  [[nodiscard]] double astray_m() const { return astray_m_; }
  /// Whether the last step turned on the spot, and would have gone on but for what is allowed.
  [[nodiscard]] bool turning() const { return turning_; }
  /// The points that lie ahead.
  [[nodiscard]] const PlannedPath& path() const { return path_; }
  [[nodiscard]] std::size_t nearest() const { return nearest_; }

 private:
  void find_nearest(const Eigen::Vector2d& at_m);
  [[nodiscard]] Eigen::Vector2d carrot_m(double look_ahead_m) const;
  [[nodiscard]] double path_speed_mps(double look_ahead_m) const;
  [[nodiscard]] Drive limited(const Drive& wish, const Drive& moving, double dt_s) const;

  FollowerConfig config_;
  RobotConfig robot_;
  PlannedPath path_;
  std::vector<double> to_end_m_;  ///< along the path, from each point
  std::size_t nearest_ = 0;
  double astray_m_ = 0;
  bool turning_ = false;
  bool at_end_ = false;
  bool arrived_ = false;
};

}  // namespace cairn::planning
