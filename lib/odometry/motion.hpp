// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "core/geometry.hpp"

namespace cairn::odometry {

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// Velocity of a body in its own frame: linear x, y, z [m/s], then angular x, y, z [rad/s].
using Twist = Vector6d;

/// The motion after `dt_s` at a steady twist, with the translation along the mean heading (second
/// order exact).
[[nodiscard]] Isometry motion_of(const Twist& twist, double dt_s);

/// Inverse of motion_of for rotations below pi; dt_s > 0.
[[nodiscard]] Twist twist_of(const Isometry& T_from_to, double dt_s);

/// Takes a covariance of a small motion given in frame b into frame a; order and sides as in Twist.
[[nodiscard]] Matrix6d covariance_in(const Isometry& T_a_b, const Matrix6d& covariance_b);

/// The nearest isometry to T, so that long products stay rigid.
[[nodiscard]] Isometry rigid(const Isometry& T);

}  // namespace cairn::odometry
