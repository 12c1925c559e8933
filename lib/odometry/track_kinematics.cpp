// SPDX-License-Identifier: Apache-2.0
#include "odometry/track_kinematics.hpp"

#include <algorithm>
#include <cmath>

namespace cairn::odometry {
namespace {

constexpr std::int64_t kKept_us = 10 * kMicrosecondsPerSecond;
constexpr std::int64_t kTimeJump_us = kMicrosecondsPerSecond;
/// Tracks may be this much faster than the robot's limit says before their ticks are not believed.
constexpr double kSpeedSlack = 2;
constexpr double kWaySlack_m = 0.05;
constexpr double kFloorShare = 0.02;     // of the way: up and down, tilt [rad per m]
constexpr double kSideShare = 0.05;      // of the way and of the turn: sideways
constexpr double kStandingSigma = 1e-4;  // [m] and [rad]

TrackWay operator+(const TrackWay& a, const TrackWay& b) {
  return {a.left_m + b.left_m, a.right_m + b.right_m};
}

}  // namespace

Eigen::Isometry2d track_motion(const TrackWay& way, double gauge_m) {
  const double turn_rad = (way.right_m - way.left_m) / gauge_m;
  const double arc_m = (way.right_m + way.left_m) / 2;
  const double half = turn_rad / 2;
  const double chord_m = std::abs(half) < 1e-9 ? arc_m : arc_m * std::sin(half) / half;
  Eigen::Isometry2d T = Eigen::Isometry2d::Identity();
  T.linear() = Eigen::Rotation2Dd(turn_rad).toRotationMatrix();
  T.translation() << chord_m * std::cos(half), chord_m * std::sin(half);
  return T;
}

Matrix6d track_covariance(const TrackWay& way, double gauge_m, double slip_sigma) {
  const double left = slip_sigma * way.left_m;
  const double right = slip_sigma * way.right_m;
  const double way_m = (std::abs(way.left_m) + std::abs(way.right_m)) / 2;
  const double tilt = kFloorShare * way_m;
  const double side = kSideShare * way_m;
  Matrix6d covariance = Matrix6d::Zero();
  covariance(0, 0) = (left * left + right * right) / 4;
  covariance(0, 5) = covariance(5, 0) = (right * right - left * left) / (2 * gauge_m);
  covariance(5, 5) = (left * left + right * right) / (gauge_m * gauge_m);
  covariance(1, 1) = side * side;
  covariance(2, 2) = covariance(3, 3) = covariance(4, 4) = tilt * tilt;
  covariance.diagonal().array() += kStandingSigma * kStandingSigma;
  return covariance;
}

Isometry in_space(const Eigen::Isometry2d& T) {
  Isometry in_space = Isometry::Identity();
  in_space.linear().topLeftCorner<2, 2>() = T.linear();
  in_space.translation().head<2>() = T.translation();
  return in_space;
}

TrackHistory::Added TrackHistory::add(const TrackReading& reading) {
  const std::int64_t chain = moments_.empty() ? 0 : moments_.back().chain;
  const Moment afresh{Eigen::Isometry2d::Identity(), {}, reading, chain + 1};
  if (moments_.empty()) {
    moments_.push_back(afresh);
    return Added::kAfresh;
  }
  const Moment& last = moments_.back();
  const std::int64_t since_us = reading.utime - last.reading.utime;
  if (since_us <= 0 && since_us >= -kTimeJump_us) return Added::kNot;
  const auto metres = [&](std::int64_t from, std::int64_t to) {
    return (static_cast<double>(to) - static_cast<double>(from)) / reading.ticks_per_m;
  };
  const TrackWay step{metres(last.reading.left_ticks, reading.left_ticks),
                      metres(last.reading.right_ticks, reading.right_ticks)};
  const double longest_m = kSpeedSlack * max_speed_mps_ * to_seconds(since_us) + kWaySlack_m;
  const bool goes_on = since_us > 0 && since_us <= kBridge_us &&
                       reading.ticks_per_m == last.reading.ticks_per_m &&
                       std::abs(step.left_m) <= longest_m && std::abs(step.right_m) <= longest_m;
  if (!goes_on) {
    moments_.clear();
    moments_.push_back(afresh);
    return Added::kAfresh;
  }
  moments_.push_back(
      {last.T_start_body * track_motion(step, gauge_m_), last.way + step, reading, chain});
  while (moments_.front().reading.utime < reading.utime - kKept_us) moments_.pop_front();
  return Added::kOn;
}

std::optional<TrackHistory::Moment> TrackHistory::at(Utime utime) const {
  const Utime until = utime - kLag_us;
  const auto after =
      std::upper_bound(moments_.begin(), moments_.end(), until,
                       [](Utime t, const Moment& moment) { return t < moment.reading.utime; });
  if (after == moments_.begin()) return std::nullopt;
  Moment moment = *std::prev(after);
  if (until - moment.reading.utime > kSilence_us) return std::nullopt;
  const double ahead_s = to_seconds(utime - moment.reading.utime);
  const double limit_mps = kSpeedSlack * max_speed_mps_;
  const TrackWay on{std::clamp(moment.reading.left_mps, -limit_mps, limit_mps) * ahead_s,
                    std::clamp(moment.reading.right_mps, -limit_mps, limit_mps) * ahead_s};
  moment.T_start_body = moment.T_start_body * track_motion(on, gauge_m_);
  moment.way = moment.way + on;
  return moment;
}

std::optional<TrackHistory::Moment> TrackHistory::newest() const {
  if (moments_.empty()) return std::nullopt;
  return moments_.back();
}

bool TrackHistory::ready_for(Utime utime, Utime now) const {
  if (moments_.empty()) return true;
  const Utime newest = moments_.back().reading.utime;
  return newest >= utime - kLag_us ||
         std::max(newest, listens_from_) < std::max(utime, now) - kSilence_us;
}

}  // namespace cairn::odometry
