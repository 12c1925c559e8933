// SPDX-License-Identifier: Apache-2.0
#include "simulation/drive_path.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace cairn::simulation {
namespace {

constexpr std::size_t kStepsPerSegment = 200;

/// A point of the curve, how far along it lies, and where it leads.
struct CurvePoint {
  double way_m;
  Eigen::Vector2d position_m;
  double heading_rad;  ///< not wrapped: rises and falls without jumps
};

std::vector<CurvePoint> closed_curve(std::span<const Eigen::Vector2d> waypoints_m) {
  const std::size_t count = waypoints_m.size();
  std::vector<CurvePoint> curve;
  for (std::size_t step = 0; step <= count * kStepsPerSegment; ++step) {
    const std::size_t segment = step / kStepsPerSegment;
    const double u =
        static_cast<double>(step % kStepsPerSegment) / static_cast<double>(kStepsPerSegment);
    const auto waypoint = [&](std::size_t i) {
      return waypoints_m[(segment + count + i - 1) % count];
    };
    const Eigen::Vector2d a = 0.5 * (waypoint(2) - waypoint(0));
    const Eigen::Vector2d b = waypoint(0) - 2.5 * waypoint(1) + 2 * waypoint(2) - 0.5 * waypoint(3);
    const Eigen::Vector2d c = 0.5 * (waypoint(3) - waypoint(0)) + 1.5 * (waypoint(1) - waypoint(2));
    const Eigen::Vector2d position = waypoint(1) + u * (a + u * (b + u * c));
    const Eigen::Vector2d tangent = a + u * (2 * b + u * 3 * c);
    const double heading = std::atan2(tangent.y(), tangent.x());
    if (curve.empty()) {
      curve.push_back({0, position, heading});
    } else {
      const CurvePoint& last = curve.back();
      curve.push_back(
          {last.way_m + (position - last.position_m).norm(), position,
           last.heading_rad + std::remainder(heading - last.heading_rad, 2 * std::numbers::pi)});
    }
  }
  return curve;
}

/// Way driven after `t_s` when speeding up evenly, driving at full speed, and slowing down evenly
/// to stand at the end.
class SpeedProfile {
 public:
  SpeedProfile(double way_m, const DriveConfig& config)
      : way_m_{way_m},
        speed_mps_{std::min(config.speed_mps, std::sqrt(way_m * config.acceleration_mps2))},
        ramp_s_{speed_mps_ / config.acceleration_mps2},
        duration_s_{way_m / speed_mps_ + ramp_s_} {}

  [[nodiscard]] double duration_s() const { return duration_s_; }
  [[nodiscard]] double way_m(double t_s) const {
    if (t_s >= duration_s_) return way_m_;
    if (t_s < ramp_s_) return 0.5 * speed_mps_ * t_s * t_s / ramp_s_;
    if (t_s > duration_s_ - ramp_s_) {
      const double left_s = duration_s_ - t_s;
      return way_m_ - 0.5 * speed_mps_ * left_s * left_s / ramp_s_;
    }
    return speed_mps_ * (t_s - 0.5 * ramp_s_);
  }

 private:
  double way_m_;
  double speed_mps_;
  double ramp_s_;
  double duration_s_;
};

Isometry pose_at(const std::vector<CurvePoint>& curve, double way_m) {
  const auto next = std::upper_bound(
      curve.begin() + 1, curve.end() - 1, way_m,
      [](double wanted_m, const CurvePoint& point) { return wanted_m < point.way_m; });
  const CurvePoint& a = *(next - 1);
  const CurvePoint& b = *next;
  const double u = std::clamp((way_m - a.way_m) / (b.way_m - a.way_m), 0.0, 1.0);
  const Eigen::Vector2d position_m = a.position_m + u * (b.position_m - a.position_m);
  Isometry T_world_body = Isometry::Identity();
  T_world_body.linear() =
      rotation_from_rpy(0, 0, a.heading_rad + u * (b.heading_rad - a.heading_rad));
  T_world_body.translation() = Eigen::Vector3d(position_m.x(), position_m.y(), 0);
  return T_world_body;
}

}  // namespace

evaluation::Trajectory drive_round(std::span<const Eigen::Vector2d> waypoints_m,
                                   const DriveConfig& config) {
  const std::vector<CurvePoint> curve = closed_curve(waypoints_m);
  const SpeedProfile profile(curve.back().way_m, config);
  const auto frames = static_cast<std::int64_t>(std::ceil(profile.duration_s() * config.rate_hz));
  evaluation::Trajectory path;
  for (std::int64_t frame = 0; frame <= frames; ++frame) {
    const double t_s = static_cast<double>(frame) / config.rate_hz;
    path.push_back({std::llround(t_s * 1e6), pose_at(curve, profile.way_m(t_s))});
  }
  return path;
}

std::vector<Eigen::Vector2d> room_tour_m() {
  return {{0, -0.95}, {0.78, -0.67}, {1.1, 0},  {0.78, 0.67},
          {0, 0.95},  {-0.78, 0.67}, {-1.1, 0}, {-0.78, -0.67}};
}

}  // namespace cairn::simulation
