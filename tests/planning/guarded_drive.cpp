// SPDX-License-Identifier: Apache-2.0
#include "guarded_drive.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "stereo/depth_to_disparity.hpp"

namespace cairn::testing {
namespace {

constexpr double kStride_m = 0.02;
constexpr double kLowest_m = 0.035;
constexpr double kMaxDisparity_px = 191;
constexpr double kFrame_s = 1.0 / 15;

Isometry in_space(const Eigen::Isometry2d& T) {
  Isometry space = Isometry::Identity();
  space.linear().topLeftCorner<2, 2>() = T.linear();
  space.translation().head<2>() = T.translation();
  return space;
}

}  // namespace

camera::RigCalibration level_rig() {
  Isometry T_body_left = Isometry::Identity();
  T_body_left.linear() = R_body_camera_forward();
  T_body_left.translation() = Eigen::Vector3d(0, 0.127, 0.30);
  const double f_px = 320 / std::tan(std::numbers::pi / 6);
  return camera::rectified_rig(f_px, f_px, 319.5, 239.5, 0.254, 640, 480, T_body_left);
}

Eyes::Eyes(const simulation::World& world, Sight sight) : rig_{level_rig()}, sight_{sight} {
  renderer_ = std::make_unique<simulation::Renderer>(
      std::move(simulation::Renderer::create(world, rig_, {}, 1).value()));
  rectifier_ =
      std::make_unique<stereo::Rectifier>(std::move(stereo::Rectifier::create(rig_).value()));
  matcher_ = std::move(stereo::make_matcher({}).value());
}

stereo::DisparityImage Eyes::look(const Isometry& T_world_body, std::int64_t frame, Utime utime) {
  const stereo::RectifiedCamera& camera = rectifier_->camera();
  if (sight_ == Sight::kStereo) {
    const auto pair = renderer_->render(T_world_body, frame);
    return matcher_->match(pair.left, pair.right, camera, utime).value();
  }
  cv::Mat_<float> depth_m = renderer_->left_depth_m(T_world_body);
  for (int row = 0; row < depth_m.rows; ++row) {
    for (int col = 0; col < depth_m.cols; ++col) {
      const double d = camera.f_px * camera.baseline_m / static_cast<double>(depth_m(row, col));
      if (d > kMaxDisparity_px || d > col) depth_m(row, col) = 0;
    }
  }
  return stereo::disparity_from_depth(depth_m, camera, 2, utime).value();
}

bool in_trouble(const simulation::World& world, const RobotConfig& robot,
                const Eigen::Isometry2d& T_world_body) {
  for (double x = -robot.length_m / 2; x <= robot.length_m / 2 + 1e-9; x += kStride_m) {
    for (double y = -robot.width_m / 2; y <= robot.width_m / 2 + 1e-9; y += kStride_m) {
      const Eigen::Vector2d p = T_world_body * Eigen::Vector2d(x, y);
      if (world.distance_m({p.x(), p.y(), -0.02}) > 0) return true;
      for (double z = kLowest_m; z <= robot.height_m; z += kStride_m) {
        if (world.distance_m({p.x(), p.y(), z}) < 0) return true;
      }
    }
  }
  return false;
}

bool ends_in_trouble(const simulation::World& world, const RobotConfig& robot,
                     const Eigen::Isometry2d& T_world_body, double speed_mps, double reaction_s) {
  const double way_m =
      speed_mps * reaction_s + speed_mps * speed_mps / (2 * robot.max_acceleration_mps2);
  for (double s = 0; s < way_m + kStride_m; s += kStride_m) {
    Eigen::Isometry2d T = T_world_body;
    T.translate(Eigen::Vector2d(std::min(s, way_m), 0));
    if (in_trouble(world, robot, T)) return true;
  }
  return false;
}

DriveLog drive_on(const simulation::World& world, Eyes& eyes,
                  const Eigen::Isometry2d& T_world_start, double wanted_mps, int frames) {
  const RobotConfig robot;
  const planning::ClearanceConfig config;
  planning::Clearance clearance(config, robot);
  DriveLog log;
  double way_m = 0;
  double speed_mps = 0;
  for (int frame = 0; frame < frames && !log.trouble; ++frame) {
    const auto utime = static_cast<Utime>(1e6 * (1 + frame * kFrame_s));
    Eigen::Isometry2d T_start_body = Eigen::Isometry2d::Identity();
    T_start_body.translate(Eigen::Vector2d(way_m, 0));
    const Eigen::Isometry2d T_world_body = T_world_start * T_start_body;
    clearance.see(eyes.look(in_space(T_world_body), frame, utime), T_start_body);
    log.allowed.push_back(clearance.judge(utime, T_start_body, 0));
    log.forward_m.push_back(way_m);
    const double allowed_mps = log.allowed.back().max_forward_mps;
    if (allowed_mps > 0 &&
        ends_in_trouble(world, robot, T_world_body, allowed_mps, config.reaction_s)) {
      ++log.unsafe;
    }
    const double target_mps = std::min(wanted_mps, allowed_mps);
    const double most_mps = robot.max_acceleration_mps2 * kFrame_s;
    speed_mps += std::clamp(target_mps - speed_mps, -most_mps, most_mps);
    way_m += speed_mps * kFrame_s;
    log.trouble = in_trouble(world, robot, T_world_body);
  }
  return log;
}

}  // namespace cairn::testing
