// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>

namespace cairn {

/// `T_a_b` maps coordinates of frame b into frame a. Robot frames: x forward, y left, z up [m].
/// Camera frames: x right, y down, z forward [m].
using Isometry = Eigen::Isometry3d;

/// The rotation that takes camera axes (x right, y down, z forward) into body axes (x forward, y
/// left, z up), for a camera that looks straight ahead.
[[nodiscard]] Eigen::Matrix3d R_body_camera_forward();

/// Rotation Rz(yaw) * Ry(pitch) * Rx(roll), angles in radians.
[[nodiscard]] Eigen::Matrix3d rotation_from_rpy(double roll_rad, double pitch_rad, double yaw_rad);

/// Heading of the x axis of `T` in the x-y plane [rad], in (-pi, pi].
[[nodiscard]] double yaw_rad(const Isometry& T);

/// Angle of a rotation [rad], in [0, pi]; exact near 0 and near pi.
[[nodiscard]] double rotation_angle_rad(const Eigen::Matrix3d& R);

/// Nearest proper rotation to M (Frobenius norm; SVD, Schoenemann 1966).
[[nodiscard]] Eigen::Matrix3d nearest_rotation(const Eigen::Matrix3d& M);

/// exp: so(3) -> SO(3) (Rodrigues 1840), `w` in radians.
[[nodiscard]] Eigen::Matrix3d exp_so3(const Eigen::Vector3d& w);

/// log: SO(3) -> so(3), in radians; inverse of exp_so3 for angles below pi.
[[nodiscard]] Eigen::Vector3d log_so3(const Eigen::Matrix3d& R);

}  // namespace cairn
