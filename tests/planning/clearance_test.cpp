// SPDX-License-Identifier: Apache-2.0
#include "planning/clearance.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "guarded_drive.hpp"
#include "simulation/scenes.hpp"

namespace cairn::testing {
namespace {

using planning::Ground;
using planning::Permission;
using simulation::box;
using simulation::BoxConfig;
using simulation::World;

constexpr double kFrame_s = 1.0 / 15;

/// A level floor, 20 x 6 m, and what else.
World floor_and(std::vector<BoxConfig> things) {
  things.push_back(box({5, 0, -0.1}, {20, 6, 0.2}));
  return simulation::world_of(std::move(things));
}

/// A robot that has driven `way_m` straight on at a steady speed, seeing true depth, and stands at
/// x = 0 of the world now.
struct Approach {
  explicit Approach(const World& world, double way_m = 1.2, double speed_mps = 0.5,
                    const planning::ClearanceConfig& config = {})
      : clearance{config, RobotConfig{}} {
    Eyes eyes(world, Sight::kTrueDepth);
    const int frames = 1 + static_cast<int>(std::ceil(way_m / speed_mps / kFrame_s));
    for (int frame = 0; frame < frames; ++frame) {
      const double x = frames == 1 ? 0 : way_m * (frame / (frames - 1.0) - 1);
      now = static_cast<Utime>(1e6 * (1 + frame * kFrame_s));
      T_start_body = Eigen::Isometry2d::Identity();
      T_start_body.translate(Eigen::Vector2d(x, 0));
      Isometry T_world_body = Isometry::Identity();
      T_world_body.translation().x() = x;
      clearance.see(eyes.look(T_world_body, frame, now), T_start_body);
    }
  }
  [[nodiscard]] Permission judge(double turn_radps = 0) const {
    return clearance.judge(now, T_start_body, turn_radps);
  }
  [[nodiscard]] Ground seen(double x_m, double y_m) const {
    return clearance.view().find(x_m, y_m)->ground;
  }

  planning::Clearance clearance;
  Utime now = 0;
  Eigen::Isometry2d T_start_body = Eigen::Isometry2d::Identity();
};

TEST(Clearance, FreeFloorThatWasSeenAllowsFullSpeed) {
  const Permission allowed = Approach(floor_and({})).judge();
  EXPECT_EQ(allowed.max_forward_mps, RobotConfig{}.max_speed_mps);
  EXPECT_EQ(allowed.reason, "free");
}

TEST(Clearance, AtStartTheGroundThatTheCamerasNeverSawAllowsCreepingAlone) {
  const Permission allowed = Approach(floor_and({}), 0).judge();
  EXPECT_EQ(allowed.max_forward_mps, 0.1);
  EXPECT_NE(allowed.reason.find("out of the cameras' sight"), std::string::npos) << allowed.reason;
}

TEST(Clearance, NothingSeenYetAllowsNothing) {
  const planning::Clearance clearance({}, {});
  EXPECT_EQ(clearance.judge(1, Eigen::Isometry2d::Identity(), 0).max_forward_mps, 0);
}

TEST(Clearance, AnImageWithoutAnswersTakesThePermissionAway) {
  Approach robot(floor_and({}));
  stereo::DisparityImage blind;
  blind.camera = stereo::Rectifier::create(level_rig())->camera();
  blind.step_px = 2;
  blind.disparity_16ths = cv::Mat_<std::uint16_t>(240, 320, std::uint16_t{0});
  blind.code = cv::Mat_<std::uint8_t>(240, 320, std::uint8_t{0});
  for (int frame = 0; frame < 6; ++frame) {
    robot.now += static_cast<Utime>(1e6 * kFrame_s);
    blind.utime = robot.now;
    robot.clearance.see(blind, robot.T_start_body);
  }
  EXPECT_EQ(robot.judge().max_forward_mps, 0);
}

TEST(Clearance, AWallTooNearForStereoAllowsNothing) {
  const World wall = floor_and({box({0.7, 0, 1}, {0.2, 6, 2})});  // its face is 0.42 m before us
  const Permission allowed = Approach(wall, 0).judge();
  EXPECT_EQ(allowed.max_forward_mps, 0) << allowed.reason;
}

TEST(Clearance, WhatWasSeenFadesAfterItsTime) {
  Approach robot(floor_and({}));
  robot.now += 3 * kMicrosecondsPerSecond;
  EXPECT_NEAR(robot.judge().max_forward_mps, planning::ClearanceConfig{}.slow_mps, 1e-9);
  robot.now += 30 * kMicrosecondsPerSecond;
  EXPECT_LE(robot.judge().max_forward_mps, planning::ClearanceConfig{}.creep_mps);
}

TEST(Clearance, ForgettingAllowsCreepingAtMostUntilItHasSeenAgain) {
  Approach robot(floor_and({}));
  robot.clearance.forget();
  EXPECT_EQ(robot.judge().max_forward_mps, 0);
}

// The highest speed whose way to a stop ends `front_margin` before the thing.
double speed_for_way_m(double way_m) {
  const planning::ClearanceConfig config;
  const double a = RobotConfig{}.max_acceleration_mps2;
  const double d = way_m - config.front_margin_m;
  if (d <= 0) return 0;
  const double t = config.reaction_s;
  return std::min(RobotConfig{}.max_speed_mps, a * (std::sqrt(t * t + 2 * d / a) - t));
}

class Obstacle : public ::testing::TestWithParam<std::pair<const char*, BoxConfig>> {};

TEST_P(Obstacle, StopsTheRobotBeforeItAndNotLongBefore) {
  const double front_m = RobotConfig{}.length_m / 2;
  const BoxConfig& thing = GetParam().second;
  for (const double way_m : {0.06, 0.12, 0.2, 0.3, 0.4}) {
    BoxConfig there = thing;
    there.centre_m[0] += front_m + way_m + thing.size_m[0] / 2;
    const Approach robot(floor_and({there}), 1.2, 0.5);
    const double truth_mps = speed_for_way_m(way_m);
    const Permission allowed = robot.judge();
    EXPECT_LE(allowed.max_forward_mps, truth_mps + 1e-9)
        << way_m << " m before it: " << allowed.reason;
    // A square of the view and one of the memory, and the speed's step.
    const double near_mps = speed_for_way_m(way_m - 0.075) - 0.025;
    EXPECT_GE(allowed.max_forward_mps, near_mps) << way_m << " m before it: " << allowed.reason;
  }
}

INSTANTIATE_TEST_SUITE_P(
    Clearance, Obstacle,
    ::testing::Values(std::pair{"thin leg", box({0, 0.02, 0.35}, {0.03, 0.03, 0.7})},
                      std::pair{"thin leg at the side", box({0, -0.14, 0.35}, {0.03, 0.03, 0.7})},
                      std::pair{"person", box({0, 0.05, 0.875}, {0.25, 0.35, 1.75})},
                      std::pair{"kerb", box({0, 0, 0.03}, {1.0, 4, 0.06})},
                      std::pair{"table top", box({0, 0, 0.33}, {0.6, 1.2, 0.04})},
                      std::pair{"wall", box({0, 0, 1}, {0.2, 6, 2})}),
    [](const auto& thing) {
      std::string name = thing.param.first;
      std::replace(name.begin(), name.end(), ' ', '_');
      return name;
    });

TEST(Clearance, WhatStandsBesideTheStripOrHangsAboveItDoesNotMatter) {
  const World passage = floor_and({box({1, 0.45, 1}, {4, 0.2, 2}), box({1, -0.45, 1}, {4, 0.2, 2}),
                                   box({1, 0, 0.7}, {1, 1, 0.04})});
  EXPECT_EQ(Approach(passage).judge().reason, "free");
}

TEST(Clearance, TurningIntoAWallIsSlowerThanPassingIt) {
  const Approach robot(floor_and({box({1, 0.4, 1}, {6, 0.2, 2})}));
  const double straight_mps = robot.judge(0).max_forward_mps;
  EXPECT_EQ(straight_mps, 0.5);
  EXPECT_LT(robot.judge(1.0).max_forward_mps, 0.35);
  EXPECT_EQ(robot.judge(-0.3).max_forward_mps, 0.5);
}

TEST(Clearance, AnEdgeIsADropHoweverDeep) {
  const double front_m = RobotConfig{}.length_m / 2;
  for (const double depth_m : {0.06, 0.15, 1.0}) {
    for (const double way_m : {0.06, 0.2, 0.4}) {
      const double edge_m = front_m + way_m;
      const World world =
          simulation::world_of({box({edge_m - 5, 0, -0.1}, {10, 6, 0.2}),
                                box({edge_m + 5, 0, -0.1 - depth_m}, {10, 6, 0.2})});
      const Permission allowed = Approach(world).judge();
      EXPECT_LE(allowed.max_forward_mps, speed_for_way_m(way_m) + 1e-9)
          << depth_m << " m deep, " << way_m << " m before it: " << allowed.reason;
    }
  }
}

TEST(Clearance, AtStartAStepOutOfSightShowsInTheHeightOfTheFloorBehindIt) {
  for (const double step_m : {0.06, -0.06}) {
    const World world = simulation::world_of(
        {box({-4.6, 0, -0.1}, {10, 6, 0.2}), box({5.4, 0, step_m - 0.1}, {10, 6, 0.2})});
    const Permission allowed = Approach(world, 0).judge();
    EXPECT_EQ(allowed.max_forward_mps, 0) << step_m << " m: " << allowed.reason;
  }
}

TEST(Clearance, RampsUpToSixDegreesAreFloor) {
  for (const double slope_deg : {-6.0, -3.0, 3.0, 6.0}) {
    const double slope = slope_deg * std::numbers::pi / 180;
    for (const double foot_m : {0.3, 0.6, 0.9, 1.5}) {
      const Eigen::Vector2d along(std::cos(slope), std::sin(slope));
      const Eigen::Vector2d up(-along.y(), along.x());
      const Eigen::Vector2d middle = Eigen::Vector2d(foot_m, 0) + 3 * along - 0.1 * up;
      const World world =
          simulation::world_of({box({foot_m - 5, 0, -0.1}, {10, 6, 0.2}),
                                box({middle.x(), 0, middle.y()}, {6, 6, 0.2}, {0, -slope_deg, 0})});
      EXPECT_EQ(Approach(world).judge().max_forward_mps, 0.5)
          << slope_deg << " degrees from " << foot_m << " m on: " << Approach(world).judge().reason;
    }
  }
}

TEST(Clearance, SomebodyWhoCrossedIsForgottenOnceTheyAreGone) {
  Approach robot(floor_and({}));
  Eyes crossing(floor_and({box({0.95, 0, 0.875}, {0.25, 0.35, 1.75})}), Sight::kTrueDepth);
  Eyes empty(floor_and({}), Sight::kTrueDepth);
  const auto next = [&](Eyes& eyes, int frames) {
    for (int i = 0; i < frames; ++i) {
      robot.now += static_cast<Utime>(1e6 * kFrame_s);
      robot.clearance.see(eyes.look(Isometry::Identity(), 0, robot.now), robot.T_start_body);
    }
  };
  next(crossing, 3);
  EXPECT_EQ(robot.seen(0.82, 0), Ground::kObstacle);
  const double before_them_mps = speed_for_way_m(0.95 - 0.125 - 0.18);
  EXPECT_LE(robot.judge().max_forward_mps, before_them_mps);
  next(empty, 8);
  EXPECT_EQ(robot.judge().reason, "free");
}

TEST(Clearance, ADistanceSensorsReadingIsInTheWay) {
  Approach robot(floor_and({}));
  planning::RangeReading sonar;
  sonar.utime = robot.now;
  sonar.T_body_sensor.translation().x() = 0.18;
  sonar.range_m = 0.25;
  sonar.half_angle_rad = 0.3;
  robot.clearance.measure(sonar, robot.T_start_body);
  EXPECT_LE(robot.judge().max_forward_mps, speed_for_way_m(0.25) + 1e-9);
  EXPECT_GT(robot.judge().max_forward_mps, 0.1);
  sonar.range_m = 0.1;
  robot.clearance.measure(sonar, robot.T_start_body);
  EXPECT_EQ(robot.judge().max_forward_mps, 0);
  EXPECT_NE(robot.judge().reason.find("obstacle"), std::string::npos);
}

}  // namespace
}  // namespace cairn::testing
