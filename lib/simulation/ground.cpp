// SPDX-License-Identifier: Apache-2.0
#include "simulation/ground.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace cairn::simulation {
namespace {

constexpr std::size_t kPointsPerTrack = 5;
constexpr std::size_t kPoints = 2 * kPointsPerTrack;

/// Where the upright line through `at` leaves a box; nothing if it misses it or leaves it through a
/// side that is no ground.
std::optional<double> top_m(const Box& box, const Eigen::Vector2d& at) {
  const Eigen::Matrix3d R_box_world = box.T_world_box.linear().transpose();
  const Eigen::Vector3d origin =
      R_box_world * (Eigen::Vector3d(at.x(), at.y(), 0) - box.T_world_box.translation());
  const Eigen::Vector3d up = R_box_world.col(2);
  double enter_m = -std::numeric_limits<double>::infinity();
  double leave_m = std::numeric_limits<double>::infinity();
  int leave_axis = 0;
  for (int axis = 0; axis < 3; ++axis) {
    if (std::abs(up[axis]) < 1e-12) {
      if (std::abs(origin[axis]) > box.half_size_m[axis]) return std::nullopt;
      continue;
    }
    const double near_m =
        (-std::copysign(box.half_size_m[axis], up[axis]) - origin[axis]) / up[axis];
    const double far_m = (std::copysign(box.half_size_m[axis], up[axis]) - origin[axis]) / up[axis];
    enter_m = std::max(enter_m, near_m);
    if (far_m < leave_m) {
      leave_m = far_m;
      leave_axis = axis;
    }
  }
  if (enter_m > leave_m) return std::nullopt;
  static const double kFlattest = std::cos(kSteepestGround_rad);
  if (std::abs(up[leave_axis]) < kFlattest) return std::nullopt;
  return leave_m;
}

/// z = height + slope_x * x + slope_y * y over the body's level frame (along its heading).
struct Plane {
  double height_m = 0;
  double slope_x = 0;
  double slope_y = 0;

  [[nodiscard]] double at(const Eigen::Vector2d& p) const {
    return height_m + slope_x * p.x() + slope_y * p.y();
  }
};

Plane plane_of(const Isometry& T_world_body, const Eigen::Vector2d& at, double yaw) {
  const Eigen::Vector3d normal = T_world_body.linear().col(2);
  const Eigen::Vector2d ahead(std::cos(yaw), std::sin(yaw));
  const Eigen::Vector2d left(-ahead.y(), ahead.x());
  const Eigen::Vector2d slope = -normal.head<2>() / normal.z();
  return {T_world_body.translation().z() + slope.dot(at - T_world_body.translation().head<2>()),
          slope.dot(ahead), slope.dot(left)};
}

Isometry pose_on(const Plane& plane, const Eigen::Vector2d& at, double yaw) {
  const Eigen::Matrix3d R_world_level = rotation_from_rpy(0, 0, yaw);
  const Eigen::Vector3d ahead = Eigen::Vector3d(1, 0, plane.slope_x).normalized();
  const Eigen::Vector3d up = Eigen::Vector3d(-plane.slope_x, -plane.slope_y, 1).normalized();
  Eigen::Matrix3d R_level_body;
  R_level_body << ahead, up.cross(ahead), up;
  Isometry T = Isometry::Identity();
  T.linear() = R_world_level * R_level_body;
  T.translation() << at, plane.height_m;
  return T;
}

struct Support {
  Eigen::Vector2d point;  ///< in the body's level frame
  double height_m;
};

Plane best_plane(std::span<const Support> supports) {
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (const Support& support : supports) {
    const Eigen::Vector3d row(1, support.point.x(), support.point.y());
    normal += row * row.transpose();
    right += row * support.height_m;
  }
  const Eigen::Vector3d solution = normal.ldlt().solve(right);
  Plane plane{solution[0], solution[1], solution[2]};
  double lift_m = 0;
  for (const Support& support : supports) {
    lift_m = std::max(lift_m, support.height_m - plane.at(support.point));
  }
  plane.height_m += lift_m;
  return plane;
}

// Its middle is carried: supports before and behind it, and under both tracks.
bool carries(std::span<const Support> supports) {
  bool ahead = false;
  bool behind = false;
  bool left = false;
  bool right = false;
  for (const Support& support : supports) {
    ahead = ahead || support.point.x() >= 0;
    behind = behind || support.point.x() <= 0;
    left = left || support.point.y() > 0;
    right = right || support.point.y() < 0;
  }
  return ahead && behind && left && right && supports.size() >= 3;
}

// Level with the ground it carries on; supports on one line across would leave the pitch open.
bool spans_length(std::span<const Support> supports) {
  const auto [low, high] = std::minmax_element(
      supports.begin(), supports.end(),
      [](const Support& a, const Support& b) { return a.point.x() < b.point.x(); });
  return low->point.x() < high->point.x();
}

}  // namespace

std::optional<double> ground_height_m(std::span<const Box* const> boxes, const Eigen::Vector2d& at,
                                      double limit_m) {
  std::optional<double> highest;
  for (const Box* box : boxes) {
    const auto height = top_m(*box, at);
    if (height && *height <= limit_m && (!highest || *height > *highest)) highest = height;
  }
  return highest;
}

Stance stand_on(std::span<const Box* const> boxes, const TrackPlan& tracks, const Isometry& before,
                const Eigen::Vector2d& at, double yaw) {
  const Plane last = plane_of(before, at, yaw);
  const Eigen::Vector2d ahead(std::cos(yaw), std::sin(yaw));
  const Eigen::Vector2d left(-ahead.y(), ahead.x());
  std::vector<Support> all;
  std::vector<Support> near;
  all.reserve(kPoints);
  near.reserve(kPoints);
  for (std::size_t i = 0; i < kPoints; ++i) {
    const double along = static_cast<double>(i % kPointsPerTrack) / (kPointsPerTrack - 1) - 0.5;
    const Eigen::Vector2d point(along * tracks.length_m,
                                (i < kPointsPerTrack ? 0.5 : -0.5) * tracks.gauge_m);
    const double plane_m = last.at(point);
    const auto height =
        ground_height_m(boxes, at + point.x() * ahead + point.y() * left, plane_m + tracks.step_m);
    if (!height) continue;
    all.push_back({point, *height});
    if (*height >= plane_m - tracks.step_m) near.push_back({point, *height});
  }
  if (carries(near) && spans_length(near)) return {pose_on(best_plane(near), at, yaw), false};
  if (carries(all) && spans_length(all)) return {pose_on(best_plane(all), at, yaw), true};
  return {pose_on(last, at, yaw), true};
}

}  // namespace cairn::simulation
