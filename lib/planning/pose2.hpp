// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "core/geometry.hpp"

namespace cairn::planning {

/// Where the robot is, from above.
struct Pose2 {
  Eigen::Vector2d at_m = Eigen::Vector2d::Zero();
  double heading_rad = 0;
};

/// The same angle in [-pi, pi].
[[nodiscard]] inline double wrapped_rad(double angle_rad) {
  return std::remainder(angle_rad, 2 * std::numbers::pi);
}

[[nodiscard]] inline Eigen::Vector2d ahead(double heading_rad) {
  return {std::cos(heading_rad), std::sin(heading_rad)};
}

/// T from above; its x axis must not point straight up.
[[nodiscard]] inline Pose2 from_above(const Isometry& T) {
  return {T.translation().head<2>(), yaw_rad(T)};
}

/// T_a_b * pose_b, all from above.
[[nodiscard]] inline Pose2 moved(const Pose2& T_a_b, const Pose2& pose_b) {
  return {T_a_b.at_m + Eigen::Rotation2Dd(T_a_b.heading_rad) * pose_b.at_m,
          wrapped_rad(T_a_b.heading_rad + pose_b.heading_rad)};
}

[[nodiscard]] inline Pose2 inverse(const Pose2& T_a_b) {
  return {-(Eigen::Rotation2Dd(-T_a_b.heading_rad) * T_a_b.at_m), -T_a_b.heading_rad};
}

}  // namespace cairn::planning
