// SPDX-License-Identifier: Apache-2.0
#include "odometry/track_prior.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace cairn::odometry {
namespace {

constexpr double kStanding_m = 1e-3;
constexpr double kSlipLasts_m = 0.3;
constexpr double kGate = 22.46;     // chi-square, 6 degrees of freedom, 99.9 %
constexpr double kUnsaidSigma = 1;  // [m] and [rad]: the tracks say nothing of it

struct Fusion {
  Belief both;
  double distance2 = 0;
};

/// The product of two normal beliefs to first order around `a`, and how far apart they are
/// (Mahalanobis 1936).
Fusion fuse(const Belief& a, const Belief& b) {
  const Isometry between = a.T_odom_body.inverse() * b.T_odom_body;
  Vector6d difference;
  difference << between.translation(), log_so3(between.linear());
  const Matrix6d sum = a.covariance + b.covariance;
  const Eigen::LDLT<Matrix6d> solver(sum);
  const Matrix6d gain = solver.solve(a.covariance).transpose();
  const Vector6d move = gain * difference;
  Fusion fusion;
  fusion.distance2 = difference.dot(solver.solve(difference));
  Isometry by = Isometry::Identity();
  by.linear() = exp_so3(move.tail<3>());
  by.translation() = move.head<3>();
  fusion.both.T_odom_body = rigid(a.T_odom_body * by);
  const Matrix6d rest = Matrix6d::Identity() - gain;
  fusion.both.covariance =
      rest * a.covariance * rest.transpose() + gain * b.covariance * gain.transpose();
  return fusion;
}

/// As track_covariance, with slip that lasts: within kSlipLasts_m the errors of small steps are one
/// error, so that their covariances, summed as if they were not, come to that of the whole way.
Matrix6d lasting_covariance(const TrackWay& way, const TrackModel& model) {
  const double way_m = (std::abs(way.left_m) + std::abs(way.right_m)) / 2;
  const double widening = way_m > 0 ? std::sqrt(std::max(1.0, kSlipLasts_m / way_m)) : 1;
  return track_covariance({widening * way.left_m, widening * way.right_m}, model.gauge_m,
                          model.slip_sigma);
}

/// Tracks that move say nothing of height, roll and pitch, and where they are this very moment is
/// reckoned.
Matrix6d on_the_floor(Matrix6d covariance, double unread_m, const TrackModel& model) {
  const double variance = unread_m * unread_m;
  covariance(0, 0) += variance / 2;
  covariance(5, 5) += 2 * variance / (model.gauge_m * model.gauge_m);
  covariance.diagonal().segment<3>(2).array() += kUnsaidSigma * kUnsaidSigma;
  return covariance;
}

}  // namespace

bool TrackStep::stands() const {
  return std::max(std::abs(way.left_m), std::abs(way.right_m)) <= kStanding_m;
}

std::optional<TrackStep> track_step(const TrackHistory::Moment& from, Utime from_utime,
                                    const TrackHistory::Moment& to, Utime to_utime,
                                    const TrackModel& model) {
  if (from.chain != to.chain) return std::nullopt;
  const auto unread_m = [&](const TrackHistory::Moment& moment, Utime utime) {
    const double ahead_s = to_seconds(utime - moment.reading.utime);
    return model.max_acceleration_mps2 * ahead_s * ahead_s / 2;
  };
  TrackStep step;
  step.T_from_to = in_space(from.T_start_body.inverse() * to.T_start_body);
  step.way = {to.way.left_m - from.way.left_m, to.way.right_m - from.way.right_m};
  step.covariance = track_covariance(step.way, model.gauge_m, model.slip_sigma);
  step.unread_m = std::hypot(unread_m(from, from_utime), unread_m(to, to_utime));
  return step;
}

TrackPrior::TrackPrior(const Belief& before, const TrackStep& step, const TrackModel& model) {
  const Isometry T_odom_body = rigid(before.T_odom_body * step.T_from_to);
  const Matrix6d carried = covariance_in(step.T_from_to.inverse(), before.covariance);
  const Matrix6d strict = carried + step.covariance;
  alone_ = {T_odom_body, carried + lasting_covariance(step.way, model)};
  if (step.stands()) standing_ = {T_odom_body, strict};
  strict_ = {T_odom_body, on_the_floor(strict, step.unread_m, model)};
  lasting_ = {T_odom_body, on_the_floor(alone_.covariance, step.unread_m, model)};
}

std::optional<Belief> TrackPrior::agreed_with(const Belief& seen) const {
  if (standing_) {
    const Fusion fusion = fuse(*standing_, seen);
    if (fusion.distance2 <= kGate) return fusion.both;
  }
  if (!(fuse(strict_, seen).distance2 <= kGate)) return std::nullopt;
  return fuse(lasting_, seen).both;
}

}  // namespace cairn::odometry
