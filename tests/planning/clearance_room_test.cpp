// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "guarded_drive.hpp"
#include "simulation/scenes.hpp"

namespace cairn::testing {
namespace {

struct Tally {
  int frames = 0;
  int unsafe = 0;
  int trouble = 0;
  int roomy = 0;  ///< drives with 2 m of free way or more
  int fast = 0;   ///< of these, those that were allowed 0.3 m/s or more
};

/// Drives from random places of the furnished room, in random directions, on until guard says no.
Tally drive_in_the_room(Sight sight, int drives, int frames) {
  const auto world = simulation::load_world(simulation::room_file()).value();
  Eyes eyes(world, sight);
  const RobotConfig robot;
  std::mt19937 random(7);
  std::uniform_real_distribution<double> x(-2.7, 2.7);
  std::uniform_real_distribution<double> y(-2.2, 2.2);
  std::uniform_real_distribution<double> heading(-std::numbers::pi, std::numbers::pi);
  Tally tally;
  while (drives > 0) {
    Eigen::Isometry2d T = Eigen::Isometry2d::Identity();
    T.translation() << x(random), y(random);
    T.rotate(Eigen::Rotation2Dd(heading(random)));
    if (in_trouble(world, robot, T)) continue;
    --drives;
    const DriveLog log = drive_on(world, eyes, T, robot.max_speed_mps, frames);
    double fastest_mps = 0;
    for (const auto& allowed : log.allowed)
      fastest_mps = std::max(fastest_mps, allowed.max_forward_mps);
    Eigen::Isometry2d ahead = T;
    double free_m = 0;
    for (; free_m < 2 && !in_trouble(world, robot, ahead); free_m += 0.02)
      ahead.translate(Eigen::Vector2d(0.02, 0));
    tally.frames += static_cast<int>(log.allowed.size());
    tally.unsafe += log.unsafe;
    tally.trouble += log.trouble ? 1 : 0;
    tally.roomy += free_m >= 2 ? 1 : 0;
    tally.fast += free_m >= 2 && fastest_mps >= 0.3 - 1e-9 ? 1 : 0;
  }
  return tally;
}

void expect_safe_and_useful(const Tally& tally) {
  ::testing::Test::RecordProperty("frames", tally.frames);
  ::testing::Test::RecordProperty("roomy", tally.roomy);
  ::testing::Test::RecordProperty("fast", tally.fast);
  EXPECT_EQ(tally.unsafe, 0) << "of " << tally.frames << " permissions";
  EXPECT_EQ(tally.trouble, 0);
  EXPECT_GT(tally.roomy, 0);
  EXPECT_EQ(tally.fast, tally.roomy) << "drives with 2 m of way that were never allowed 0.3 m/s";
}

TEST(ClearanceInTheRoom, WithTrueDepthItIsSafeAndUseful) {
  expect_safe_and_useful(drive_in_the_room(Sight::kTrueDepth, 12, 110));
}

TEST(ClearanceInTheRoom, WithStereoItIsSafeAndUseful) {
  expect_safe_and_useful(drive_in_the_room(Sight::kStereo, 8, 110));
}

}  // namespace
}  // namespace cairn::testing
