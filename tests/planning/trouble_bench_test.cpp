// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "explorer_bench.hpp"

namespace cairn::testing {
namespace {

using planning::Phase;

simulation::Box box(const Eigen::Vector3d& middle_m, const Eigen::Vector3d& size_m) {
  simulation::Box made;
  made.T_world_box.translation() = middle_m;
  made.half_size_m = size_m / 2;
  return made;
}

/// A closed room of 4 x 3 m; the robot starts at its west end and looks east.
simulation::World bare_room() {
  simulation::World world;
  world.boxes = {box({0, 0, -0.1}, {4.4, 3.4, 0.2}),   box({0, 0, 2.6}, {4.4, 3.4, 0.2}),
                 box({2.1, 0, 1.25}, {0.2, 3.4, 2.5}), box({-2.1, 0, 1.25}, {0.2, 3.4, 2.5}),
                 box({0, 1.6, 1.25}, {4.4, 0.2, 2.5}), box({0, -1.6, 1.25}, {4.4, 0.2, 2.5})};
  world.T_world_start.translation() = Eigen::Vector3d(-1.3, 0, 0);
  return world;
}

BenchConfig fine_map() {
  BenchConfig config;
  config.resolution_m = 0.02;
  return config;
}

TEST(TroubleBench, ThinLegsAreDrivenRound) {
  simulation::World world = bare_room();
  for (const double y : {-0.7, -0.1, 0.35, 0.9}) {
    world.boxes.push_back(box({0.1, y, 0.35}, {0.03, 0.03, 0.7}));
    world.boxes.push_back(box({0.9, y - 0.2, 0.35}, {0.03, 0.03, 0.7}));
  }
  ExplorerBench bench(world, fine_map());
  bench.navigator().explore(0);
  bench.run(120);
  EXPECT_EQ(bench.navigator().report().phase, Phase::kArrived) << bench.story();
  EXPECT_EQ(bench.collisions(), 0) << bench.story();
}

TEST(TroubleBench, AGoalInAWallIsRefusedAndOneBeyondItToo) {
  ExplorerBench bench(bare_room(), {});
  bench.navigator().explore(0);
  bench.run(120);
  ASSERT_TRUE(bench.navigator().idle()) << bench.story();
  const auto answer = [&](const Eigen::Vector2d& at_world_m) {
    bench.navigator().go(1, {bench.to_map_m(at_world_m), {}});
    bench.run(10);
    EXPECT_EQ(bench.navigator().report().phase, Phase::kRefused);
    return bench.navigator().report().reason;
  };
  EXPECT_EQ(answer({2.05, 0}).rfind("occupied", 0), 0U) << bench.navigator().report().reason;
  EXPECT_EQ(answer({1.9, 0}).rfind("occupied", 0), 0U) << bench.navigator().report().reason;
  EXPECT_EQ(answer({3.5, 0}).rfind("unknown", 0), 0U) << bench.navigator().report().reason;
}

// Not reached yet, since the bench has the simulator's body and disparities: guard refuses the way
// round for want of floor in sight, and the goal is given up.
TEST(TroubleBench, DISABLED_WhatIsPutInTheWayIsDrivenRound) {
  ExplorerBench bench(bare_room(), fine_map());
  bench.navigator().explore(0);
  bench.run(120);
  ASSERT_TRUE(bench.navigator().idle()) << bench.story();
  bench.navigator().go(1, {bench.to_map_m({-1.4, 0}), M_PI_2});
  bench.run(60);
  ASSERT_EQ(bench.navigator().report().phase, Phase::kArrived) << bench.story();
  bench.navigator().go(2, {bench.to_map_m({1.4, 0}), {}});
  const double before_m = bench.driven_m();
  while (bench.driven_m() < before_m + 0.6 && !bench.navigator().idle()) bench.step();
  bench.put(box({0.6, 0, 0.3}, {0.4, 1.2, 0.6}));
  bench.run(200);
  EXPECT_EQ(bench.navigator().report().phase, Phase::kArrived) << bench.story();
  EXPECT_LT((bench.in_world().at_m - Eigen::Vector2d(1.4, 0)).norm(), 0.1);
  EXPECT_EQ(bench.collisions(), 0) << bench.story();
}

TEST(TroubleBench, WhenThereIsNoWayLeftItSaysSo) {
  ExplorerBench bench(bare_room(), {});
  bench.navigator().explore(0);
  bench.run(120);
  bench.navigator().go(1, {bench.to_map_m({-1.4, 0}), 0.0});
  bench.run(60);
  ASSERT_EQ(bench.navigator().report().phase, Phase::kArrived) << bench.story();
  bench.put(box({0.2, 0, 0.3}, {0.4, 3, 0.6}));
  bench.navigator().go(2, {bench.to_map_m({1.4, 0}), {}});
  bench.run(200);
  EXPECT_EQ(bench.navigator().report().phase, Phase::kRefused) << bench.story();
  EXPECT_EQ(bench.navigator().report().reason.rfind("unreachable", 0), 0U);
  EXPECT_EQ(bench.collisions(), 0) << bench.story();
}

TEST(TroubleBench, WhatGuardNeverAllowsIsGivenUp) {
  ExplorerBench bench(bare_room(), {});
  bench.meddle = [](planning::Situation& now) { now.allowed_mps = 0; };
  bench.navigator().explore(0);
  bench.run(300);
  EXPECT_TRUE(bench.navigator().idle()) << bench.story();
  EXPECT_EQ(bench.collisions(), 0);
}

// Not reached since the bench has the simulator's disparities: 0.91. The robot is led too near to a
// wall, where guard takes made-up answers for a drop.
TEST(TroubleBench, DISABLED_AMapThatShiftsUnderTheOdometryIsFollowed) {
  ExplorerBench bench(bare_room(), {});
  // The odometry frame drifts away by 20 cm and 9 degrees in half a minute.
  bench.meddle = [&](planning::Situation& now) {
    const double share = std::min(1.0, bench.time_s() / 30);
    now.T_map_odom = {share * Eigen::Vector2d(0.15, -0.13), 0.15 * share};
    now.in_odom = planning::moved(planning::inverse(now.T_map_odom), now.in_odom);
  };
  bench.navigator().explore(0);
  bench.run(150);
  EXPECT_EQ(bench.navigator().report().phase, Phase::kArrived) << bench.story();
  EXPECT_GE(bench.coverage(), 0.95) << bench.story();
  EXPECT_EQ(bench.collisions(), 0);
}

TEST(TroubleBench, TheSameRunTwiceIsTheSameToTheBit) {
  const auto track = [] {
    ExplorerBench bench(bare_room(), {});
    bench.navigator().explore(0);
    std::vector<double> numbers;
    for (int i = 0; i < 15 * 25; ++i) {
      bench.step();
      numbers.push_back(bench.in_world().at_m.x());
      numbers.push_back(bench.in_world().heading_rad);
    }
    return numbers;
  };
  EXPECT_EQ(track(), track());
}

}  // namespace
}  // namespace cairn::testing
