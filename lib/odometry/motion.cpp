// SPDX-License-Identifier: Apache-2.0
#include "odometry/motion.hpp"

namespace cairn::odometry {
namespace {

Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& v) {
  Eigen::Matrix3d M;
  M << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return M;
}

}  // namespace

Isometry motion_of(const Twist& twist, double dt_s) {
  const Eigen::Vector3d turn = twist.tail<3>() * dt_s;
  Isometry T = Isometry::Identity();
  T.linear() = exp_so3(turn);
  T.translation() = exp_so3(turn / 2) * (twist.head<3>() * dt_s);
  return T;
}

Twist twist_of(const Isometry& T_from_to, double dt_s) {
  const Eigen::Vector3d turn = log_so3(T_from_to.linear());
  Twist twist;
  twist.head<3>() = exp_so3(-turn / 2) * T_from_to.translation() / dt_s;
  twist.tail<3>() = turn / dt_s;
  return twist;
}

Matrix6d covariance_in(const Isometry& T_a_b, const Matrix6d& covariance_b) {
  Matrix6d adjoint = Matrix6d::Zero();
  adjoint.topLeftCorner<3, 3>() = T_a_b.linear();
  adjoint.bottomRightCorner<3, 3>() = T_a_b.linear();
  adjoint.topRightCorner<3, 3>() = cross_matrix(T_a_b.translation()) * T_a_b.linear();
  return adjoint * covariance_b * adjoint.transpose();
}

Isometry rigid(const Isometry& T) {
  Isometry result = T;
  result.linear() = nearest_rotation(T.linear());
  return result;
}

}  // namespace cairn::odometry
