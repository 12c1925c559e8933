// SPDX-License-Identifier: Apache-2.0
#include "simulation/floor_sight.hpp"

#include <algorithm>
#include <cmath>

namespace cairn::simulation {
namespace {

/// Points to look at lie this much above the ground, clear of it.
constexpr double kAbove_m = 0.004;

Eigen::AlignedBox2d view_of(const Eye& eye) {
  const int right = eye.width_px - 1;
  const int bottom = eye.height_px - 1;
  Eigen::AlignedBox2d view(Eigen::Vector2d(-10, -10), Eigen::Vector2d(10, 10));
  const auto ray = [&eye](int col, int row) {
    return Eigen::Vector2d(eye.ray(eye.pixel(col, row)).head<2>().cast<double>());
  };
  for (int row = 0; row <= bottom; ++row) {
    view.min().x() = std::max(view.min().x(), ray(0, row).x());
    view.max().x() = std::min(view.max().x(), ray(right, row).x());
  }
  for (int col = 0; col <= right; ++col) {
    view.min().y() = std::max(view.min().y(), ray(col, 0).y());
    view.max().y() = std::min(view.max().y(), ray(col, bottom).y());
  }
  return view;
}

}  // namespace

FloorSight::FloorSight(RayScene scene, const RobotConfig& robot, ReachableFloor floor,
                       const FloorSightConfig& config)
    : scene_{std::move(scene)},
      half_body_m_{robot.length_m / 2, robot.width_m / 2},
      floor_{std::move(floor)},
      config_{config},
      seen_(floor_.cells().size(), 0) {}

Result<FloorSight> FloorSight::create(const World& world, const camera::RigCalibration& rig,
                                      const RobotConfig& robot, ReachableFloor floor,
                                      const FloorSightConfig& config) {
  if (const auto ok = camera::check(rig); !ok) return tl::make_unexpected(ok.error());
  const auto eye = make_eye(rig.left, rig.width_px, rig.height_px, rig.T_body_left);
  if (!eye) return fail("left " + eye.error().message);
  auto scene = RayScene::create(world.boxes);
  if (!scene) return tl::make_unexpected(scene.error());
  FloorSight sight(std::move(*scene), robot, std::move(floor), config);
  sight.T_body_eye_ = rig.T_body_left;
  sight.view_ = view_of(*eye);
  return sight;
}

double FloorSight::share() const {
  return seen_.empty() ? 0 : static_cast<double>(count_) / static_cast<double>(seen_.size());
}

void FloorSight::look(const Isometry& T_world_body) {
  stand_on(T_world_body);
  if (T_world_last_) {
    const Isometry moved = T_world_last_->inverse() * T_world_body;
    if (moved.translation().norm() < config_.every_m &&
        rotation_angle_rad(moved.linear()) < config_.every_rad) {
      return;
    }
  }
  T_world_last_ = T_world_body;
  look_from(T_world_body * T_body_eye_);
}

void FloorSight::count(std::size_t cell) {
  if (seen_[cell] == 0) ++count_;
  seen_[cell] = 1;
}

void FloorSight::stand_on(const Isometry& T_world_body) {
  const double reach_m = half_body_m_.norm() + ReachableFloor::kCell_m;
  const Eigen::Vector2d middle_m = T_world_body.translation().head<2>();
  for (double y = -reach_m; y <= reach_m; y += ReachableFloor::kCell_m) {
    for (double x = -reach_m; x <= reach_m; x += ReachableFloor::kCell_m) {
      const int cell = floor_.cell_at(middle_m + Eigen::Vector2d(x, y));
      if (cell < 0) continue;
      const auto index = static_cast<std::size_t>(cell);
      const Eigen::Vector3d at_body = T_world_body.inverse() * floor_.cells()[index].middle_m;
      if ((at_body.head<2>().cwiseAbs().array() <= half_body_m_.array()).all() &&
          std::abs(at_body.z()) < half_body_m_.x()) {
        count(index);
      }
    }
  }
}

void FloorSight::look_from(const Isometry& T_world_eye) {
  const Isometry T_eye_world = T_world_eye.inverse();
  for (std::size_t i = 0; i < seen_.size(); ++i) {
    if (seen_[i] != 0) continue;
    const Eigen::Vector3d point_m =
        floor_.cells()[i].middle_m + kAbove_m * Eigen::Vector3d::UnitZ();
    const Eigen::Vector3d at_eye = T_eye_world * point_m;
    if (!(at_eye.z() > 0 && at_eye.z() <= config_.max_range_m)) continue;
    if (!view_.contains(Eigen::Vector2d(at_eye.head<2>() / at_eye.z()))) continue;
    if (scene_.sees(T_world_eye.translation(), point_m)) count(i);
  }
}

}  // namespace cairn::simulation
