// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "core/config.hpp"

namespace cairn {

/// The robot's body and what its tracks can do: what simulator, motor, guard, planner and odometry
/// must agree on. The body frame lies on the floor, midway between the tracks.
struct RobotConfig {
  double length_m = 0.36;
  double width_m = 0.30;
  double height_m = 0.40;
  double track_gauge_m = 0.26;
  double max_speed_mps = 0.5;
  double max_turn_radps = 1.0;
  double max_acceleration_mps2 = 1.0;
  double ticks_per_m = 5000;

  void visit(ConfigVisitor& v) {
    v.number("length_m", length_m, {0.05, 5}, "m", "of the body, along its way");
    v.number("width_m", width_m, {0.05, 5}, "m", "of the body, over the tracks");
    v.number("height_m", height_m, {0.05, 5}, "m", "of the body, cameras included");
    v.number("track_gauge_m", track_gauge_m, {0.05, 5}, "m",
             "distance between the middles of the tracks");
    v.number("max_speed_mps", max_speed_mps, {0.01, 5}, "m/s", "of the body, and of each track");
    v.number("max_turn_radps", max_turn_radps, {0.05, 10}, "rad/s", "of the body");
    v.number("max_acceleration_mps2", max_acceleration_mps2, {0.05, 20}, "m/s^2", "of each track");
    v.number("ticks_per_m", ticks_per_m, {1, 1e6}, "1/m", "encoder counts per metre of track");
  }

  /// Of the circle around the body frame's origin that the body never leaves while it turns [m].
  [[nodiscard]] double turning_radius_m() const { return 0.5 * std::hypot(length_m, width_m); }
};

}  // namespace cairn
