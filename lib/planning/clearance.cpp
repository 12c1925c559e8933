// SPDX-License-Identifier: Apache-2.0
#include "planning/clearance.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace cairn::planning {
namespace {

constexpr double kStride_m = 0.02;
constexpr double kSpeedStep_mps = 0.025;
constexpr double kRounding = 1e-9;
constexpr double kSightDepth_m = 0.12;  // how far beyond view_from_m floor must be seen
constexpr double kSightBefore_m = 0.1;
constexpr std::size_t kStridesBefore = 6;
constexpr double kCameNearer_m = 0.05;  // the robot by itself, to what it sees no more

std::int64_t microseconds(double seconds) { return static_cast<std::int64_t>(seconds * 1e6); }

}  // namespace

std::string Clearance::Limit::reason() const {
  if (!ahead_m) return what;
  char text[64];
  std::snprintf(text, sizeof text, "%s %.2f m%s", what, *ahead_m, after);
  return text;
}

Clearance::Clearance(const ClearanceConfig& config, const RobotConfig& robot)
    : config_{config}, robot_{robot}, view_{config.ground, robot} {}

void Clearance::forget() {
  memory_.forget();
  seen_utime_.reset();
}

void Clearance::see(const stereo::DisparityImage& image, const Eigen::Isometry2d& T_start_body) {
  if (!seen_utime_) began_at_m_ = T_start_body.translation();
  view_.look(image);
  memory_.add(view_, image, T_start_body);
  seen_utime_ = image.utime;
  const Isometry& T = image.camera.T_body_camera;
  const Eigen::Vector3d right_eye_m = T * Eigen::Vector3d(image.camera.baseline_m, 0, 0);
  eyes_m_ = {T.translation().head<2>(), right_eye_m.head<2>()};
}

void Clearance::measure(const RangeReading& reading, const Eigen::Isometry2d& T_start_body) {
  const Eigen::Isometry2d T_start_sensor = T_start_body * reading.T_body_sensor;
  const double step_rad =
      std::min(0.1, GroundMemory::kSpot_m / std::max(reading.range_m, GroundMemory::kSpot_m));
  for (double angle = -reading.half_angle_rad; angle <= reading.half_angle_rad + kRounding;
       angle += step_rad) {
    const Eigen::Vector2d beam(std::cos(angle), std::sin(angle));
    memory_.block(T_start_sensor * (reading.range_m * beam), reading.utime);
  }
}

// What a spot allows, by what was last seen of it.
Clearance::Limit Clearance::spot_limit(const Eigen::Vector2d& at_body_m, Utime now,
                                       const Eigen::Isometry2d& T_start_body) const {
  const GroundSpot spot = memory_.at(T_start_body * at_body_m);
  const double ahead_m = at_body_m.x() - robot_.length_m / 2;
  const std::int64_t obstacle_us = microseconds(config_.obstacle_memory_s);
  if (spot.blocked && spot.obstacle_utime >= now - obstacle_us)
    return {0, spot.drop ? "drop at" : "obstacle at", ahead_m};
  const bool missed = spot.missed_utime > spot.floor_utime + microseconds(config_.sight_hole_s);
  if (!missed && spot.floor_utime >= now - microseconds(config_.memory_s))
    return {robot_.max_speed_mps, "free"};
  if (!missed && spot.floor_utime >= now - microseconds(config_.slow_memory_s))
    return {config_.slow_mps, "floor seen long ago at", ahead_m};
  if (!missed && at_body_m.x() < config_.ground.view_from_m) {
    const double began_m = config_.ground.view_from_m + kSightDepth_m;
    if (spot.floor_utime != GroundSpot::kNever ||
        (T_start_body * at_body_m - began_at_m_).norm() < began_m)
      return {config_.creep_mps, "out of the cameras' sight at", ahead_m};
  }
  return {0, "nothing seen from", ahead_m, " on"};
}

bool Clearance::floor_in_sight(double y_m, const Eigen::Isometry2d& T_start_body) const {
  const double from_m = config_.ground.view_from_m;
  const Utime lately = *seen_utime_ - microseconds(config_.sight_hole_s);
  for (double x = from_m - kSightBefore_m; x <= from_m + kSightDepth_m; x += kStride_m) {
    const GroundSpot spot = memory_.at(T_start_body * Eigen::Vector2d(x, y_m));
    if (!spot.blocked && spot.floor_utime >= lately) return true;
  }
  return false;
}

// Of what is known, the near side is known, too: floor was seen just before it since it is there.
// Only the far side may be in sight of who stands at the cameras' nearest range.
bool Clearance::hidden_by_something_known(const Eigen::Vector2d& from_m,
                                          const Eigen::Vector2d& to_m,
                                          const Eigen::Isometry2d& T_start_body) const {
  const Utime lately = *seen_utime_ - microseconds(config_.memory_s);
  const Utime just_now = *seen_utime_ - microseconds(config_.sight_hole_s);
  const Eigen::Vector2d way = to_m - from_m;
  const double stride = kStride_m / way.norm();
  std::array<Utime, kStridesBefore> floor_before;
  floor_before.fill(GroundSpot::kNever);
  std::size_t strides = 0;
  for (double share = stride; share <= 1; share += stride) {
    const Eigen::Vector2d p = from_m + share * way;
    if (p.x() < robot_.length_m / 2) continue;
    const GroundSpot spot = memory_.at(T_start_body * p);
    if (!spot.blocked) {
      floor_before[strides++ % kStridesBefore] = spot.floor_utime;
      continue;
    }
    if (spot.drop || spot.obstacle_utime < lately) continue;
    const bool came_nearer = p.x() < static_cast<double>(spot.obstacle_ahead_m) - kCameNearer_m;
    const Utime floor_utime = *std::max_element(floor_before.begin(), floor_before.end());
    if (floor_utime >= spot.blocked_since && (came_nearer || spot.obstacle_utime >= just_now))
      return true;
  }
  return false;
}

bool Clearance::lane_in_sight(double y_m, const Eigen::Isometry2d& T_start_body) const {
  if (floor_in_sight(y_m, T_start_body)) return true;
  const Eigen::Vector2d to_m(config_.ground.view_from_m + kSightDepth_m, y_m);
  return std::any_of(eyes_m_.begin(), eyes_m_.end(), [&](const Eigen::Vector2d& eye_m) {
    return hidden_by_something_known(eye_m, to_m, T_start_body);
  });
}

// Every lane must show floor where sight of it begins, unless what hides it is known.
Clearance::Limit Clearance::sight_limit(const Eigen::Isometry2d& T_start_body) const {
  const double half_m = robot_.width_m / 2 + config_.side_margin_m;
  for (double y = -half_m; y <= half_m + kRounding; y += GroundMemory::kSpot_m) {
    if (lane_in_sight(y, T_start_body)) continue;
    return {0, "nothing seen from", config_.ground.view_from_m - robot_.length_m / 2, " on"};
  }
  return {robot_.max_speed_mps, "free"};
}

Clearance::Limit Clearance::sweep_limit(double speed_mps, double turn_radps, Utime now,
                                        const Eigen::Isometry2d& T_start_body) const {
  // On at that speed and turn until the brakes bite, then both fade out; then the margin, straight.
  const double braking_mps2 = robot_.max_acceleration_mps2;
  const double stop_m = speed_mps * config_.reaction_s + speed_mps * speed_mps / (2 * braking_mps2);
  const double turn_rad = turn_radps * (config_.reaction_s + speed_mps / (2 * braking_mps2));
  const double way_m = stop_m + config_.front_margin_m;
  const double half_m = robot_.width_m / 2 + config_.side_margin_m;
  const double front_m = robot_.length_m / 2;
  Limit limit{robot_.max_speed_mps, "free"};
  Eigen::Vector2d at_m = Eigen::Vector2d::Zero();
  const int strides = static_cast<int>(std::ceil(way_m / kStride_m));
  for (int i = 0; i <= strides; ++i) {
    const double s = way_m * i / strides;
    const double heading_rad = turn_rad * std::min(1.0, s / stop_m);
    const Eigen::Vector2d ahead(std::cos(heading_rad), std::sin(heading_rad));
    const Eigen::Vector2d left(-ahead.y(), ahead.x());
    if (i > 0) at_m += ahead * (way_m / strides);
    for (double y = -half_m; y <= half_m + kRounding; y += kStride_m) {
      const Limit spot = spot_limit(at_m + front_m * ahead + y * left, now, T_start_body);
      if (spot.max_mps < limit.max_mps) limit = spot;
      if (limit.max_mps <= 0) return limit;
    }
  }
  return limit;
}

Permission Clearance::judge(Utime now, const Eigen::Isometry2d& T_start_body,
                            double turn_radps) const {
  if (!seen_utime_) return {0, "nothing seen yet"};
  if (const Limit sight = sight_limit(T_start_body); sight.max_mps <= 0) return {0, sight.reason()};
  Limit limit{robot_.max_speed_mps, "free"};
  const int steps = static_cast<int>(std::ceil(robot_.max_speed_mps / kSpeedStep_mps));
  for (int step = steps; step > 0; --step) {
    const double speed_mps = std::min(robot_.max_speed_mps, step * kSpeedStep_mps);
    const Limit faster = limit;
    limit = sweep_limit(speed_mps, turn_radps, now, T_start_body);
    if (limit.max_mps >= speed_mps - kRounding) return {speed_mps, faster.reason()};
  }
  return {0, limit.reason()};
}

}  // namespace cairn::planning
