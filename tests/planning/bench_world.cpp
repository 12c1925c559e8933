// SPDX-License-Identifier: Apache-2.0
#include "bench_world.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "stereo/depth_to_disparity.hpp"

namespace cairn::testing {
namespace {

using planning::Cell;
using planning::CellGrid;
using planning::kCell_m;
using simulation::Box;

constexpr double kBaseline_m = 0.254;
constexpr double kHeight_m = 0.30;
constexpr double kNearest_m = 0.73;
constexpr double kFarthest_m = 9;
constexpr double kNoise_px = 0.3;  // of 640
constexpr double kLowest_m = 0.03;
constexpr double kHeights_m[] = {0.04, 0.1, 0.2, 0.3, 0.4};

/// A box as a ray from one point meets it.
struct Target {
  Eigen::Vector3f origin;     ///< of the rays, in the box
  Eigen::Matrix3f R_box_cam;  ///< takes directions into the box
  Eigen::Vector3f half;
};

float entry(const Target& target, const Eigen::Vector3f& ray) {
  const Eigen::Vector3f d = target.R_box_cam * ray;
  float enter = 0;
  float leave = std::numeric_limits<float>::infinity();
  for (int axis = 0; axis < 3; ++axis) {
    const float a = (-target.half(axis) - target.origin(axis)) / d(axis);
    const float b = (target.half(axis) - target.origin(axis)) / d(axis);
    enter = std::max(enter, std::min(a, b));
    leave = std::min(leave, std::max(a, b));
  }
  return enter <= leave && enter > 0 ? enter : std::numeric_limits<float>::infinity();
}

bool inside(const Box& box, const Eigen::Vector3d& point_world) {
  const Eigen::Vector3d p = box.T_world_box.inverse() * point_world;
  return (p.cwiseAbs() - box.half_size_m).maxCoeff() < 0;
}

/// Distance from the box's plan, for upright boxes; that of its middle plane for others.
double plan_distance_m(const Box& box, const Eigen::Vector2d& at_m) {
  const double z = box.T_world_box.translation().z();
  const Eigen::Vector3d p = box.T_world_box.inverse() * Eigen::Vector3d(at_m.x(), at_m.y(), z);
  return (p.cwiseAbs() - box.half_size_m).cwiseMax(0).head<2>().norm();
}

double half_height_m(const Box& box) {
  return box.T_world_box.linear().row(2).cwiseAbs().dot(box.half_size_m.transpose());
}

}  // namespace

stereo::RectifiedCamera coarse_camera(int width_px, int height_px) {
  stereo::RectifiedCamera camera;
  camera.width_px = width_px;
  camera.height_px = height_px;
  camera.f_px = 0.5 * width_px / std::tan(std::numbers::pi / 6);
  camera.cx_px = 0.5 * (width_px - 1);
  camera.cy_px = 0.5 * (height_px - 1);
  camera.baseline_m = kBaseline_m;
  camera.T_body_camera.linear() = R_body_camera_forward();
  camera.T_body_camera.translation() = Eigen::Vector3d(0, kBaseline_m / 2, kHeight_m);
  return camera;
}

stereo::DisparityImage BenchEyes::look(const Isometry& T_world_body, Utime utime) {
  const Isometry T_world_camera = T_world_body * camera_.T_body_camera;
  const Eigen::Vector3d eye = T_world_camera.translation();
  const Eigen::Vector3d forward = T_world_camera.linear().col(2);
  std::vector<Target> targets;
  for (const Box& box : boxes_) {
    const double radius = box.half_size_m.norm();
    const Eigen::Vector3d to = box.T_world_box.translation() - eye;
    if (to.norm() > kFarthest_m + radius || to.dot(forward) < -radius) continue;
    const Isometry T_box_camera = box.T_world_box.inverse() * T_world_camera;
    targets.push_back({T_box_camera.translation().cast<float>(),
                       T_box_camera.linear().cast<float>(), box.half_size_m.cast<float>()});
  }
  cv::Mat_<float> depth_m(camera_.height_px, camera_.width_px, 0.0F);
  const double fb = camera_.f_px * camera_.baseline_m;
  std::normal_distribution<double> noise(0, kNoise_px * camera_.width_px / 640);
  for (int row = 0; row < depth_m.rows; ++row) {
    for (int col = 0; col < depth_m.cols; ++col) {
      const Eigen::Vector3f ray(static_cast<float>((col - camera_.cx_px) / camera_.f_px),
                                static_cast<float>((row - camera_.cy_px) / camera_.f_px), 1);
      float nearest = std::numeric_limits<float>::infinity();
      for (const Target& target : targets) nearest = std::min(nearest, entry(target, ray));
      const double error_px = noise(random_);
      const double disparity_px = fb / static_cast<double>(nearest);
      if (nearest < kNearest_m || disparity_px > col || nearest > kFarthest_m) continue;
      depth_m(row, col) = static_cast<float>(fb / std::max(0.1, disparity_px + error_px));
    }
  }
  return stereo::disparity_from_depth(depth_m, camera_, 1, utime).value();
}

bool touches(const std::vector<Box>& boxes, const RobotConfig& robot,
             const Isometry& T_world_body) {
  const Eigen::Vector3d at = T_world_body.translation();
  for (const Box& box : boxes) {
    const Eigen::Vector3d middle = box.T_world_box.translation();
    if ((middle - at).norm() > box.half_size_m.norm() + 0.5) continue;
    if (middle.z() + half_height_m(box) < at.z() + kLowest_m) continue;
    for (double x = -robot.length_m / 2; x <= robot.length_m / 2 + 1e-9; x += 0.02) {
      for (double y = -robot.width_m / 2; y <= robot.width_m / 2 + 1e-9; y += 0.02) {
        for (const double z : kHeights_m) {
          if (inside(box, T_world_body * Eigen::Vector3d(x, y, z))) return true;
        }
      }
    }
  }
  return false;
}

CellGrid<std::uint8_t> reachable_floor(const std::vector<Box>& boxes, const RobotConfig& robot,
                                       const Eigen::Vector2d& start_m) {
  constexpr std::int32_t kHalf = 400;
  const double radius_m = robot.turning_radius_m();
  CellGrid<std::uint8_t> stands({-kHalf, -kHalf, 2 * kHalf, 2 * kHalf}, 0);
  std::vector<const Box*> obstacles;
  std::vector<const Box*> grounds;
  for (const Box& box : boxes) {
    const double top = box.T_world_box.translation().z() + half_height_m(box);
    const double bottom = box.T_world_box.translation().z() - half_height_m(box);
    if (bottom < robot.height_m && top > kLowest_m) obstacles.push_back(&box);
    if (std::abs(top) < 1e-6) grounds.push_back(&box);
  }
  const auto can_stand = [&](Cell cell) {
    const Eigen::Vector2d at = planning::centre_m(cell);
    return std::any_of(grounds.begin(), grounds.end(),
                       [&](const Box* box) { return plan_distance_m(*box, at) <= 0; }) &&
           std::none_of(obstacles.begin(), obstacles.end(),
                        [&](const Box* box) { return plan_distance_m(*box, at) < radius_m; });
  };
  std::vector<Cell> queue{planning::cell_at(start_m)};
  stands.values[stands.box.index(queue.front())] = 1;
  for (std::size_t i = 0; i < queue.size(); ++i) {
    for (const planning::CellStep step : planning::kFourSteps) {
      const Cell to = queue[i] + step;
      if (!stands.box.contains(to) || stands.at(to, 1) != 0 || !can_stand(to)) continue;
      stands.values[stands.box.index(to)] = 1;
      queue.push_back(to);
    }
  }
  CellGrid<std::uint8_t> floor = stands;
  const auto reach = static_cast<std::int32_t>(radius_m / kCell_m);
  for (const Cell& cell : queue) {
    for (std::int32_t dy = -reach; dy <= reach; ++dy) {
      for (std::int32_t dx = -reach; dx <= reach; ++dx) {
        const Cell beside{cell.x + dx, cell.y + dy};
        if (std::hypot(dx, dy) * kCell_m <= radius_m && floor.box.contains(beside))
          floor.values[floor.box.index(beside)] = 1;
      }
    }
  }
  return floor;
}

}  // namespace cairn::testing
