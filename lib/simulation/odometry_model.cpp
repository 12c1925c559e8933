// SPDX-License-Identifier: Apache-2.0
#include "simulation/odometry_model.hpp"

#include <algorithm>
#include <cmath>

#include "simulation/random_normal.hpp"

namespace cairn::simulation {
namespace {

/// Of each axis, in a step of at least kFullWay_m or kFullTurn_rad.
constexpr double kPosition_m = 2e-4;
constexpr double kYaw_rad = 1.5e-4;
constexpr double kTilt_rad = 7e-5;
constexpr double kFullWay_m = 0.01;
constexpr double kFullTurn_rad = 0.02;
constexpr double kScale = 0.003;
/// A covariance of nothing would be taken for certainty.
constexpr double kLeastShare = 0.01;

}  // namespace

OdometryModel::OdometryModel(std::uint64_t seed)
    : seed_{seed},
      way_scale_{1 + kScale * normal_random(hash64(seed, 1))},
      turn_scale_{1 + kScale * normal_random(hash64(seed, 2))} {}

OdometryModel::Step OdometryModel::step(const Isometry& T_world_body, Utime utime) {
  Step result;
  if (T_world_last_) {
    const Isometry motion = T_world_last_->inverse() * T_world_body;
    Eigen::Vector3d way_m = motion.translation();
    Eigen::Vector3d turn_rad = log_so3(motion.linear());
    const double moved = std::min(1.0, way_m.norm() / kFullWay_m + turn_rad.norm() / kFullTurn_rad);
    Eigen::Matrix<double, 6, 1> sigma;
    sigma << kPosition_m, kPosition_m, kPosition_m, kTilt_rad, kTilt_rad, kYaw_rad;
    const auto error = [&](std::uint64_t axis) {
      const double sigma_now = std::sqrt(moved) * sigma[static_cast<Eigen::Index>(axis)];
      return sigma_now * normal_random(hash64(hash64(seed_, 3 + axis), steps_));
    };
    way_m = way_scale_ * way_m + Eigen::Vector3d(error(0), error(1), error(2));
    turn_rad = turn_scale_ * turn_rad + Eigen::Vector3d(error(3), error(4), error(5));
    Isometry made = Isometry::Identity();
    made.linear() = exp_so3(turn_rad);
    made.translation() = way_m;
    T_odom_body_ = T_odom_body_ * made;
    T_odom_body_.linear() = nearest_rotation(T_odom_body_.linear());
    const double dt_s = to_seconds(std::max<std::int64_t>(1, utime - last_utime_));
    result.linear_mps = way_m / dt_s;
    result.angular_radps = turn_rad / dt_s;
    result.variance = std::max(moved, kLeastShare) * sigma.cwiseAbs2();
  }
  ++steps_;
  T_world_last_ = T_world_body;
  last_utime_ = utime;
  result.T_odom_body = T_odom_body_;
  return result;
}

}  // namespace cairn::simulation
