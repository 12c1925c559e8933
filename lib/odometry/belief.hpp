// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/geometry.hpp"
#include "odometry/motion.hpp"

namespace cairn::odometry {

/// Where the body is, and how far that may be off: the covariance of a small motion of the body in
/// its own frame, order as in Twist [m^2, rad^2].
struct Belief {
  Isometry T_odom_body = Isometry::Identity();
  Matrix6d covariance = Matrix6d::Zero();
};

}  // namespace cairn::odometry
