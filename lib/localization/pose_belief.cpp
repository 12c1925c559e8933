// SPDX-License-Identifier: Apache-2.0
#include "localization/pose_belief.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace cairn::localization {
namespace {

/// Turning on the spot is weighed against driving as what the tracks do, which are so far out [m].
constexpr double kTurnLever_m = 0.13;
constexpr double kStanding_m = 0.0005;
/// How far the bias wanders in a step, and goes in all, in deviations of a step.
constexpr double kBiasWander = 0.2;
constexpr double kMostBias = 2;
constexpr double kLeastVariance = 1e-12;

Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

/// The bias may wander, and be at most so large, as the noise that odometry gives for its step
/// says.
void loosen_bias(Eigen::Ref<Eigen::Matrix4d> bias, const Eigen::Vector2d& said,
                 const Matrix6d& step) {
  const double moved_m = std::hypot(said.x(), said.y() * kTurnLever_m);
  if (moved_m < kStanding_m) return;
  const double ahead = step(0, 0) / (moved_m * moved_m);
  const double turn = step(5, 5) / (moved_m * moved_m);
  const Eigen::Vector4d variance(ahead, ahead * kTurnLever_m * kTurnLever_m, turn,
                                 turn * kTurnLever_m * kTurnLever_m);
  for (int i = 0; i < 4; ++i) {
    const double most = kMostBias * kMostBias * variance[i];
    const double room = std::clamp(1 - bias(i, i) / most, 0.0, 1.0);
    bias(i, i) += kBiasWander * kBiasWander * variance[i] * room;
  }
}

}  // namespace

double PoseBelief::sigma_m() const {
  return std::sqrt(std::max(0.0, covariance.diagonal().head<3>().maxCoeff()));
}

double PoseBelief::sigma_rad() const {
  return std::sqrt(std::max(0.0, covariance.diagonal().tail<3>().maxCoeff()));
}

PoseBelief moved(const PoseBelief& belief, const Motion& motion) {
  // What the body did, as odometry says it: metres ahead, radians turned.
  const Eigen::Vector2d said(motion.T_from_to.translation().x(), yaw_rad(motion.T_from_to));
  Isometry T_from_to = motion.T_from_to;
  T_from_to.translation().x() += belief.bias.head<2>().dot(said);
  T_from_to.linear() = T_from_to.linear() * exp_so3({0, 0, belief.bias.tail<2>().dot(said)});
  PoseBelief after;
  after.bias = belief.bias;
  after.T_map_body = belief.T_map_body * T_from_to;
  after.T_map_body.linear() = nearest_rotation(after.T_map_body.linear());
  const Eigen::Matrix3d R = after.T_map_body.linear();
  const Eigen::Vector3d way = after.T_map_body.translation() - belief.T_map_body.translation();

  using Matrix10d = Eigen::Matrix<double, 10, 10>;
  Matrix10d carry = Matrix10d::Identity();
  carry.block<3, 3>(0, 3) = -cross_matrix(way);
  carry.block<3, 2>(0, 6) = belief.T_map_body.linear().col(0) * said.transpose();
  carry.block<3, 2>(3, 8) = R.col(2) * said.transpose();
  Matrix10d joint;
  joint << belief.covariance, belief.bias_with_pose.transpose(), belief.bias_with_pose,
      belief.bias_covariance;
  joint = (carry * joint * carry.transpose()).eval();
  Matrix6d into_map = Matrix6d::Zero();
  into_map.topLeftCorner<3, 3>() = into_map.bottomRightCorner<3, 3>() = R;
  joint.topLeftCorner<6, 6>() += into_map * motion.covariance * into_map.transpose();
  loosen_bias(joint.bottomRightCorner<4, 4>(), said, motion.claimed);
  after.covariance = joint.topLeftCorner<6, 6>();
  after.pose_with_map = carry.topLeftCorner<6, 6>() * belief.pose_with_map;
  after.bias_with_pose = joint.bottomLeftCorner<4, 6>();
  after.bias_covariance = joint.bottomRightCorner<4, 4>();
  return after;
}

PoseBelief with_pose(const PoseBelief& belief, const Isometry& T_map_body,
                     const Matrix6d& covariance) {
  PoseBelief after = belief;
  const Matrix6d regular = belief.covariance + kLeastVariance * Matrix6d::Identity();
  const Eigen::Matrix<double, 4, 6> follow =
      regular.ldlt().solve(belief.bias_with_pose.transpose()).transpose();
  after.T_map_body = T_map_body;
  after.covariance = covariance;
  after.bias += follow * change_between(belief.T_map_body, T_map_body);
  after.bias_with_pose = follow * covariance;
  after.bias_covariance += follow * (covariance - belief.covariance) * follow.transpose();
  return after;
}

}  // namespace cairn::localization
