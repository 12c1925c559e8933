// SPDX-License-Identifier: Apache-2.0
#include "localization/odometry_chain.hpp"

#include <algorithm>
#include <cmath>

namespace cairn::localization {
namespace {

/// Longer than this nobody was blind: it makes no difference any more.
constexpr double kMostBlind_s = 10;
/// A pose that goes on is no farther off than this, and this share of what the speed explains.
constexpr double kGoesOn_m = 0.1;
constexpr double kGoesOn_rad = 0.2;
constexpr double kGoesOnShare = 1.5;

void widen(Matrix6d& covariance, double sigma_m, double sigma_rad) {
  covariance.diagonal().head<3>().array() += sigma_m * sigma_m;
  covariance.diagonal().tail<3>().array() += sigma_rad * sigma_rad;
}

}  // namespace

Motion OdometryChain::put(const OdometryFrame& frame) {
  Motion motion;
  if (last_) {
    const double gap_s = std::clamp(to_seconds(frame.utime - last_->utime), 0.0, kMostBlind_s);
    motion.T_from_to = last_->T_odom_body.inverse() * frame.T_odom_body;
    motion.covariance = motion.claimed = frame.step_covariance;
    if (frame.epoch != last_->epoch && begins_anew(frame, motion.T_from_to, gap_s)) {
      motion.jumped = true;
      motion.T_from_to = Isometry::Identity();
      T_chain_odom_ = T_chain_body_ * frame.T_odom_body.inverse();
      widen(motion.covariance, config_.blind_speed_mps * gap_s, config_.blind_turn_radps * gap_s);
    }
    const double way_m = motion.T_from_to.translation().norm();
    const double turn_rad = rotation_angle_rad(motion.T_from_to.linear());
    widen(motion.covariance, config_.drift_m * std::sqrt(way_m),
          std::sqrt(config_.drift_rad * config_.drift_rad * way_m +
                    config_.turn_share * config_.turn_share * turn_rad));
    if (gap_s > 0) {
      speed_mps_ = way_m / gap_s;
      turn_radps_ = turn_rad / gap_s;
    }
  } else {
    T_chain_odom_ = Isometry::Identity();
  }
  last_ = frame;
  T_chain_body_ = T_chain_odom_ * frame.T_odom_body;
  return motion;
}

bool OdometryChain::begins_anew(const OdometryFrame& frame, const Isometry& T_from_to,
                                double gap_s) const {
  return frame.T_odom_body.isApprox(Isometry::Identity()) ||
         T_from_to.translation().norm() > kGoesOn_m + kGoesOnShare * speed_mps_ * gap_s ||
         rotation_angle_rad(T_from_to.linear()) > kGoesOn_rad + kGoesOnShare * turn_radps_ * gap_s;
}

void OdometryChain::restore(const Isometry& T_chain_odom, const OdometryFrame& last) {
  T_chain_odom_ = T_chain_odom;
  last_ = last;
  T_chain_body_ = T_chain_odom * last.T_odom_body;
}

}  // namespace cairn::localization
