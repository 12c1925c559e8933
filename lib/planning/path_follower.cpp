// SPDX-License-Identifier: Apache-2.0
#include "planning/path_follower.hpp"

#include <algorithm>
#include <cmath>

namespace cairn::planning {
namespace {

constexpr double kSearch_m = 0.8;      // along the path, for the point that is nearest
constexpr double kSlowest_mps = 0.06;  // slower, tracks stick
constexpr double kSlowestTurn_radps = 0.15;
constexpr double kTurned_rad = 0.2;  // a turn on the spot towards a path ends here
constexpr double kRefusedTurn_rad = 0.3;
constexpr double kCurveShare = 0.8;  // of the turn rate that curves may use

double radians(double degrees) { return degrees * std::numbers::pi / 180; }

}  // namespace

void PathFollower::follow(PlannedPath path) {
  path_ = std::move(path);
  to_end_m_.assign(path_.points.size(), 0);
  for (std::size_t i = path_.points.size(); i-- > 1;) {
    to_end_m_[i - 1] = to_end_m_[i] + (path_.points[i].at_m - path_.points[i - 1].at_m).norm();
  }
  nearest_ = 0;
  astray_m_ = 0;
  turning_ = at_end_ = arrived_ = false;
}

void PathFollower::drop() { follow({}); }

double PathFollower::distance_left_m() const {
  return following() && !at_end_ ? to_end_m_[nearest_] : 0;
}

void PathFollower::find_nearest(const Eigen::Vector2d& at_m) {
  const std::size_t from = nearest_;
  double best_m = (path_.points[from].at_m - at_m).norm();
  for (std::size_t i = from + 1;
       i < path_.points.size() && to_end_m_[from] - to_end_m_[i] < kSearch_m; ++i) {
    const double distance_m = (path_.points[i].at_m - at_m).norm();
    if (distance_m >= best_m) continue;
    best_m = distance_m;
    nearest_ = i;
  }
  astray_m_ = best_m;
}

Eigen::Vector2d PathFollower::carrot_m(double look_ahead_m) const {
  std::size_t i = nearest_;
  while (i + 1 < path_.points.size() && to_end_m_[nearest_] - to_end_m_[i] < look_ahead_m) ++i;
  return path_.points[i].at_m;
}

double PathFollower::path_speed_mps(double look_ahead_m) const {
  double speed_mps = robot_.max_speed_mps;
  for (std::size_t i = nearest_;
       i < path_.points.size() && to_end_m_[nearest_] - to_end_m_[i] <= look_ahead_m; ++i) {
    speed_mps = std::min(speed_mps, path_.points[i].speed_mps);
  }
  return std::max(speed_mps, kSlowest_mps);
}

Drive PathFollower::limited(const Drive& wish, const Drive& moving, double dt_s) const {
  const double dv_mps = robot_.max_acceleration_mps2 * dt_s;
  const double dw_radps = config_.turn_acceleration_radps2 * dt_s;
  const double most_turn = robot_.max_turn_radps;
  return {std::clamp(wish.forward_mps, moving.forward_mps - dv_mps, moving.forward_mps + dv_mps),
          std::clamp(std::clamp(wish.turn_radps, -most_turn, most_turn),
                     moving.turn_radps - dw_radps, moving.turn_radps + dw_radps)};
}

Drive PathFollower::halt(const Drive& moving, double dt_s) const {
  return limited({0, 0}, moving, dt_s);
}

Drive PathFollower::turn(double left_rad, const Drive& moving, double dt_s,
                         double most_radps) const {
  const double size = std::abs(left_rad);
  const double braking = std::sqrt(config_.turn_acceleration_radps2 * size);
  const double rate = std::min({std::max(braking, kSlowestTurn_radps), config_.turn_radps,
                                robot_.max_turn_radps, most_radps});
  return limited({0, std::copysign(rate, left_rad)}, moving, dt_s);
}

Drive PathFollower::step(const Pose2& robot, const Drive& moving, double dt_s,
                         const DriveLimits& allowed) {
  if (!following() || arrived_) return halt(moving, dt_s);
  if (!at_end_) find_nearest(robot.at_m);
  const Eigen::Vector2d to_end = path_.points.back().at_m - robot.at_m;
  const bool last = nearest_ + 1 == path_.points.size();
  if (to_end.norm() < config_.arrived_m ||
      (last && ahead(robot.heading_rad).dot(to_end) < 0 && to_end.norm() < 2 * config_.arrived_m)) {
    at_end_ = true;
  }
  if (at_end_) {
    turning_ = false;
    const double left_rad =
        path_.heading_rad ? wrapped_rad(*path_.heading_rad - robot.heading_rad) : 0;
    if (std::abs(left_rad) <= radians(config_.arrived_deg)) {
      arrived_ = true;
      return halt(moving, dt_s);
    }
    turning_ = true;
    return turn(left_rad, moving, dt_s, allowed.turn_radps);
  }
  const double speed_ahead = std::clamp(moving.forward_mps * config_.look_ahead_s,
                                        config_.least_look_ahead_m, config_.most_look_ahead_m);
  const double look_ahead_m =
      std::min(speed_ahead, config_.least_look_ahead_m + path_.points[nearest_].room_m);
  const Eigen::Vector2d way = carrot_m(look_ahead_m) - robot.at_m;
  const double bearing_rad = wrapped_rad(std::atan2(way.y(), way.x()) - robot.heading_rad);
  const double size_rad = std::abs(bearing_rad);
  const double on_spot_rad =
      allowed.forward_mps > 0 ? radians(config_.turn_on_spot_deg) : kRefusedTurn_rad;
  turning_ = size_rad > (turning_ ? kTurned_rad : on_spot_rad);
  if (turning_) return turn(bearing_rad, moving, dt_s, allowed.turn_radps);
  const double curvature = 2 * std::sin(bearing_rad) / std::max(way.norm(), 0.1);
  double speed_mps =
      std::min(path_speed_mps(look_ahead_m),
               std::sqrt(2 * config_.braking_mps2 * to_end_m_[nearest_]) + kSlowest_mps);
  if (std::abs(curvature) > 1e-6)
    speed_mps = std::min(speed_mps, kCurveShare * robot_.max_turn_radps / std::abs(curvature));
  speed_mps *= std::max(0.3, std::cos(bearing_rad));
  speed_mps = std::max(speed_mps, kSlowest_mps);
  speed_mps = std::min(speed_mps, allowed.forward_mps);
  const Drive drive = limited({speed_mps, 0}, moving, dt_s);
  const double forward_mps = std::min(drive.forward_mps, allowed.forward_mps);
  return {forward_mps, limited({0, curvature * forward_mps}, moving, dt_s).turn_radps};
}

}  // namespace cairn::planning
