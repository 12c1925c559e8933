// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/geometry.hpp"
#include "localization/odometry_chain.hpp"
#include "localization/pose_change.hpp"

namespace cairn::localization {

/// How odometry errs the same way all the time, a slipping track above all: by how much the body
/// goes farther ahead [m], then turns more [rad], than it says, each per metre ahead and per radian
/// turned. How far that may go is taken from the covariances that odometry gives.
using MotionBias = Eigen::Vector4d;

/// A pose in the map and how sure it is: a normal distribution of changes of it, joint with the
/// bias of the motion that led to it.
struct PoseBelief {
  Isometry T_map_body = Isometry::Identity();
  Matrix6d covariance = Matrix6d::Zero();
  MotionBias bias = MotionBias::Zero();
  Eigen::Matrix4d bias_covariance = Eigen::Matrix4d::Zero();
  Eigen::Matrix<double, 4, 6> bias_with_pose = Eigen::Matrix<double, 4, 6>::Zero();
  /// Covariance of the pose's error (rows) with that of the map in view, which is the same from
  /// frame to frame and is not estimated (Schmidt 1966).
  Matrix6d pose_with_map = Matrix6d::Zero();

  /// The largest standard deviation along an axis, and about one.
  [[nodiscard]] double sigma_m() const;
  [[nodiscard]] double sigma_rad() const;
};

/// What comes of it when the body moves.
[[nodiscard]] PoseBelief moved(const PoseBelief& belief, const Motion& motion);

/// What comes of it when the pose, as such, becomes known better: the bias follows, as far as the
/// two hang together (Rauch, Tung and Striebel 1965).
[[nodiscard]] PoseBelief with_pose(const PoseBelief& belief, const Isometry& T_map_body,
                                   const Matrix6d& covariance);

}  // namespace cairn::localization
