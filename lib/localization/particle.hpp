// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/geometry.hpp"

namespace cairn::localization {

/// One guess of where the body is in the map. How it is tilted is known (odometry feels the floor)
/// and the same for all guesses of a filter.
struct Particle {
  double x_m = 0;
  double y_m = 0;
  double z_m = 0;
  double yaw_rad = 0;
  double weight = 0;  ///< of all that a filter holds, these sum to 1
};

/// T_map_body. `R_tilt` is the attitude without its yaw: Ry(pitch) * Rx(roll).
[[nodiscard]] inline Isometry pose_of(const Particle& particle, const Eigen::Matrix3d& R_tilt) {
  Isometry T = Isometry::Identity();
  T.linear() = Eigen::AngleAxisd(particle.yaw_rad, Eigen::Vector3d::UnitZ()) * R_tilt;
  T.translation() << particle.x_m, particle.y_m, particle.z_m;
  return T;
}

/// The attitude of a pose without its yaw.
[[nodiscard]] inline Eigen::Matrix3d tilt_of(const Isometry& T_map_body) {
  return Eigen::AngleAxisd(-yaw_rad(T_map_body), Eigen::Vector3d::UnitZ()) * T_map_body.linear();
}

}  // namespace cairn::localization
