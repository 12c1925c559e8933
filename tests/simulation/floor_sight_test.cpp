// SPDX-License-Identifier: Apache-2.0
#include "simulation/floor_sight.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "scenes.hpp"
#include "simulation/renderer.hpp"

namespace cairn::simulation {
namespace {

FloorSight sight_in(const World& world, const camera::RigCalibration& rig,
                    const FloorSightConfig& config = {}) {
  auto floor = ReachableFloor::flood(world, world.T_world_start.translation().head<2>(), {});
  EXPECT_TRUE(floor) << floor.error().message;
  auto sight = FloorSight::create(world, rig, RobotConfig{}, std::move(*floor), config);
  EXPECT_TRUE(sight) << sight.error().message;
  return std::move(*sight);
}

/// Whether a rendered depth image shows the ground there.
bool shown(const cv::Mat_<float>& depth_m, const camera::RigCalibration& rig,
           const Isometry& T_world_eye, const Eigen::Vector3d& point_m, double max_range_m) {
  const Eigen::Vector3d at_eye = T_world_eye.inverse() * point_m;
  if (!(at_eye.z() > 0 && at_eye.z() <= max_range_m)) return false;
  const double u = rig.left.cx_px + rig.left.fx_px * at_eye.x() / at_eye.z();
  const double v = rig.left.cy_px + rig.left.fy_px * at_eye.y() / at_eye.z();
  const auto col = static_cast<int>(std::lround(u));
  const auto row = static_cast<int>(std::lround(v));
  if (col < 0 || row < 0 || col >= depth_m.cols || row >= depth_m.rows) return false;
  return std::abs(depth_m(row, col) - at_eye.z()) < 0.02 * at_eye.z() + 0.02;
}

TEST(FloorSight, CountsWhatARenderedDepthImageShows) {
  const auto rig = test_rig();
  for (const char* name : {"room", "apartment", "hand-drawn"}) {
    const auto world = load_world(world_file(name));
    ASSERT_TRUE(world) << world.error().message;
    const auto renderer = Renderer::create(*world, rig, {}, 1);
    ASSERT_TRUE(renderer) << renderer.error().message;
    FloorSightConfig config;
    config.max_range_m = 3;
    std::mt19937 random(7);
    int differ = 0;
    int counted = 0;
    for (int view = 0; view < 6; ++view) {
      FloorSight sight = sight_in(*world, rig, config);
      const Isometry T = free_pose(*world, 0.25, random);
      sight.look(T);
      const auto depth_m = renderer->left_depth_m(T);
      for (std::size_t i = 0; i < sight.seen().size(); ++i) {
        const Eigen::Vector3d& point_m = sight.floor().cells()[i].middle_m;
        const Eigen::Vector3d at_body = T.inverse() * point_m;
        const bool under = std::abs(at_body.x()) <= 0.18 && std::abs(at_body.y()) <= 0.15;
        const bool expected =
            under || shown(depth_m, rig, T * rig.T_body_left, point_m, config.max_range_m);
        counted += expected;
        differ += expected != (sight.seen()[i] != 0);
      }
    }
    EXPECT_GT(counted, 1000) << name;
    EXPECT_LT(differ, counted / 50) << name << ": borders only";
  }
}

TEST(FloorSight, FillsUpOverADriveAndNeverShrinks) {
  const auto world = load_world(room_file());
  ASSERT_TRUE(world) << world.error().message;
  FloorSight sight = sight_in(*world, simulated_rig());
  EXPECT_EQ(sight.share(), 0);
  double last = 0;
  for (int i = 0; i <= 72; ++i) {
    sight.look(pose_2d(-1.2, -1.1, 2 * std::numbers::pi * i / 72));
    EXPECT_GE(sight.share(), last);
    last = sight.share();
  }
  EXPECT_GT(last, 0.5);
  EXPECT_LT(last, 0.98);  // the sofa, the stool and the desk hide some
  for (const auto& [x, y] : {std::pair{1.5, 1.2}, {1.6, -1.2}, {-1, 1.2}, {-0.8, -2}, {2, -2}}) {
    for (int i = 0; i < 72; ++i) sight.look(pose_2d(x, y, 2 * std::numbers::pi * i / 72));
  }
  EXPECT_GT(sight.share(), 0.97);
}

TEST(FloorSight, WhatWasDrivenOverCountsWithoutBeingSeen) {
  const auto world = load_world(world_file("plain"));
  ASSERT_TRUE(world) << world.error().message;
  FloorSightConfig blind;
  blind.max_range_m = 0;
  FloorSight sight = sight_in(*world, simulated_rig(), blind);
  sight.look(pose_2d(0, 0, 0.4));
  EXPECT_NEAR(sight.share() * sight.floor().area_m2(), 0.36 * 0.30, 0.02);
  for (int i = 0; i <= 100; ++i) sight.look(pose_2d(0.01 * i, 0, 0));
  EXPECT_NEAR(sight.share() * sight.floor().area_m2(), 0.36 * 0.30 + 1 * 0.30, 0.05);
}

}  // namespace
}  // namespace cairn::simulation
