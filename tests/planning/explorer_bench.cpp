// SPDX-License-Identifier: Apache-2.0
#include "explorer_bench.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace cairn::testing {
namespace {

constexpr std::int64_t kFrame_us = 66'667;
constexpr double kFrame_s = 1.0 / 15;

Isometry in_space(const planning::Pose2& pose) {
  Isometry T = Isometry::Identity();
  T.linear() = rotation_from_rpy(0, 0, pose.heading_rad);
  T.translation().head<2>() = pose.at_m;
  return T;
}

Eigen::Isometry2d in_plane(const planning::Pose2& pose) {
  Eigen::Isometry2d T = Eigen::Isometry2d::Identity();
  T.linear() = Eigen::Rotation2Dd(pose.heading_rad).toRotationMatrix();
  T.translation() = pose.at_m;
  return T;
}

}  // namespace

ExplorerBench::ExplorerBench(const simulation::World& world, const BenchConfig& config,
                             const planning::NavigatorConfig& navigation)
    : config_{config},
      boxes_{world.boxes},
      start_{planning::from_above(world.T_world_start)},
      robot_{start_},
      eyes_{boxes_, coarse_camera(config.image_width_px, config.image_height_px), config.seed},
      map_{config.resolution_m},
      guard_{{}, robot_config_},
      navigator_{navigation, robot_config_},
      floor_{reachable_floor(boxes_, robot_config_, start_.at_m)} {}

planning::Pose2 ExplorerBench::in_map() const {
  return planning::moved(planning::inverse(start_), robot_);
}

Eigen::Vector2d ExplorerBench::to_map_m(const Eigen::Vector2d& point_world_m) const {
  return planning::moved(planning::inverse(start_), {point_world_m, 0}).at_m;
}

void ExplorerBench::look() {
  const auto image = eyes_.look(in_space(robot_), now_);
  const Isometry T_map_camera = in_space(in_map()) * image.camera.T_body_camera;
  (void)integrator_.integrate(image, T_map_camera, map_).value();
  const auto bricks = map_.dirty_bricks();
  (void)replica_.apply(mapping::make_delta(map_, 1, now_, bricks)).value();
  map_.clear_dirty();
  guard_.see(image, in_plane(in_map()));
}

void ExplorerBench::move() {
  permission_ = guard_.judge(now_, in_plane(in_map()), moving_.turn_radps);
  const double allowed_mps = permission_.max_forward_mps;
  planning::Situation situation;
  situation.utime = now_;
  situation.in_odom = in_map();
  situation.forward_mps = moving_.forward_mps;
  situation.turn_radps = moving_.turn_radps;
  situation.located = true;
  situation.allowed_mps = allowed_mps;
  if (meddle) meddle(situation);
  navigator_.step(situation, replica_, replica_.take_changes());
  planning::Drive wish = navigator_.drive(now_);
  wish.forward_mps = std::min(wish.forward_mps, allowed_mps);
  wish.turn_radps *= 1 - config_.turn_slip;
  const double dv = robot_config_.max_acceleration_mps2 * kFrame_s;
  const double dw = 2 * dv / robot_config_.track_gauge_m;
  moving_.forward_mps =
      std::clamp(wish.forward_mps, moving_.forward_mps - dv, moving_.forward_mps + dv);
  moving_.turn_radps =
      std::clamp(wish.turn_radps, moving_.turn_radps - dw, moving_.turn_radps + dw);
  const double middle_rad = robot_.heading_rad + 0.5 * moving_.turn_radps * kFrame_s;
  robot_.at_m += moving_.forward_mps * kFrame_s * planning::ahead(middle_rad);
  robot_.heading_rad = planning::wrapped_rad(robot_.heading_rad + moving_.turn_radps * kFrame_s);
  driven_m_ += std::abs(moving_.forward_mps) * kFrame_s;
}

void ExplorerBench::write_diary() {
  const planning::PlanReport& report = navigator_.report();
  if (report.reason == last_said_) return;
  last_said_ = report.reason;
  char line[300];
  std::snprintf(line, sizeof line, "%6.1f s (%.2f, %.2f) %.0f deg: %s", time_s(), robot_.at_m.x(),
                robot_.at_m.y(), robot_.heading_rad * 180 / M_PI, report.reason.c_str());
  diary_.emplace_back(line);
}

void ExplorerBench::step() {
  if (frame_++ % config_.frames_per_image == 0) look();
  move();
  write_diary();
  now_ += kFrame_us;
  if (testing::touches(boxes_, robot_config_, in_space(robot_))) ++touches_;
}

void ExplorerBench::run(double at_most_s) {
  const double until_s = time_s() + at_most_s;
  do {
    step();
  } while (!navigator_.idle() && time_s() < until_s);
}

double ExplorerBench::coverage() const {
  const planning::GroundMap& ground = navigator_.ground_model().ground();
  double all = 0;
  double seen = 0;
  for (std::size_t i = 0; i < floor_.values.size(); ++i) {
    if (floor_.values[i] == 0) continue;
    ++all;
    const Eigen::Vector2d at_m = to_map_m(planning::centre_m(floor_.box.cell(i)));
    if (ground.at(planning::cell_at(at_m)) == planning::ColumnClass::kFree) ++seen;
  }
  return seen / all;
}

}  // namespace cairn::testing
