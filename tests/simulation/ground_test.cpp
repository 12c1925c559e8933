// SPDX-License-Identifier: Apache-2.0
#include "simulation/ground.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "scenes.hpp"

namespace cairn::simulation {
namespace {

constexpr double kRadPerDeg = std::numbers::pi / 180;
const TrackPlan kTracks{0.36, 0.26, 0.02};

std::vector<const Box*> all_of(const World& world) {
  std::vector<const Box*> boxes;
  for (const Box& box : world.boxes) boxes.push_back(&box);
  return boxes;
}

double pitch_rad(const Isometry& T) { return -std::asin(T.linear()(2, 0)); }

/// A floor, and on it a ramp that rises along x from x = 0, z = 0.
World ramp_world(double slope_deg) {
  const double slope = slope_deg * kRadPerDeg;
  const double length_m = 4;
  const double thickness_m = 0.2;
  const Eigen::Vector3d middle =
      0.5 * length_m * Eigen::Vector3d(std::cos(slope), 0, std::sin(slope)) -
      0.5 * thickness_m * Eigen::Vector3d(-std::sin(slope), 0, std::cos(slope));
  return world_of(
      {box({0, 0, -0.1}, {20, 20, 0.2}),
       box({middle.x(), middle.y(), middle.z()}, {length_m, 4, thickness_m}, {0, -slope_deg, 0})});
}

TEST(GroundHeight, IsTheHighestUnderTheLimit) {
  const World world = world_of({box({0, 0, -0.1}, {10, 10, 0.2}), box({0, 0, 0.4}, {1, 1, 0.1})});
  const auto boxes = all_of(world);
  EXPECT_NEAR(*ground_height_m(boxes, {0, 0}, 1), 0.45, 1e-12);
  EXPECT_NEAR(*ground_height_m(boxes, {0, 0}, 0.3), 0, 1e-12);
  EXPECT_NEAR(*ground_height_m(boxes, {3, 3}, 1), 0, 1e-12);
  EXPECT_FALSE(ground_height_m(boxes, {30, 3}, 1));
}

TEST(GroundHeight, ASteepSideIsNoGround) {
  const auto world = ramp_world(20);
  EXPECT_NEAR(*ground_height_m(all_of(world), {1, 0}, 5), 0, 1e-9);
}

TEST(Stance, OnTheFloorIsLevel) {
  const World world = world_of({box({0, 0, -0.1}, {10, 10, 0.2})});
  const Stance stance = stand_on(all_of(world), kTracks, Isometry::Identity(), {1, 2}, 0.7);
  EXPECT_FALSE(stance.tipped);
  EXPECT_TRUE(stance.T_world_body.isApprox(pose_2d(1, 2, 0.7), 1e-12));
}

class StanceOnARamp : public testing::TestWithParam<double> {};

TEST_P(StanceOnARamp, HasItsHeightAndSlopeWhicheverWayItLooks) {
  const double slope = GetParam() * kRadPerDeg;
  const auto world = ramp_world(GetParam());
  for (int i = 0; i < 8; ++i) {
    const double yaw = i * std::numbers::pi / 4;
    Isometry before = pose_2d(1.5, 0, yaw);
    before.translation().z() = 1.5 * std::tan(slope);
    const Stance stance = stand_on(all_of(world), {0.36, 0.26, 0.2}, before, {1.5, 0}, yaw);
    EXPECT_FALSE(stance.tipped);
    EXPECT_NEAR(stance.T_world_body.translation().z(), 1.5 * std::tan(slope), 1e-9);
    const Eigen::Vector3d up(-std::sin(slope), 0, std::cos(slope));
    EXPECT_NEAR((stance.T_world_body.linear().col(2) - up).norm(), 0, 1e-9);
    EXPECT_NEAR(yaw_rad(stance.T_world_body), std::remainder(yaw, 2 * std::numbers::pi), 1e-9);
  }
  EXPECT_GT(slope, 0);
}

INSTANTIATE_TEST_SUITE_P(Slopes, StanceOnARamp, testing::Values(2.0, 5.0, 10.0));

TEST(Stance, IsNoseUpOnARampThatRises) {
  const auto world = ramp_world(5);
  Isometry before = pose_2d(1.5, 0, 0);
  before.translation().z() = 1.5 * std::tan(5 * kRadPerDeg);
  const Stance stance = stand_on(all_of(world), kTracks, before, {1.5, 0}, 0);
  EXPECT_NEAR(pitch_rad(stance.T_world_body), -5 * kRadPerDeg, 1e-9);
}

TEST(Stance, BridgesADitchThatIsNotUnderItsMiddle) {
  const World world = world_of({box({-5, 0, -0.1}, {9.8, 10, 0.2}),   // to x = -0.1
                                box({5, 0, -0.1}, {9.9, 10, 0.2})});  // from x = 0.05
  const Stance stance = stand_on(all_of(world), kTracks, Isometry::Identity(), {0, 0}, 0);
  EXPECT_FALSE(stance.tipped);
  EXPECT_NEAR(stance.T_world_body.translation().z(), 0, 1e-12);
}

TEST(Stance, FallsWhereNothingCarriesItsFront) {
  const World world = world_of({box({-5, 0, -0.1}, {10, 10, 0.2})});  // to x = 0
  EXPECT_FALSE(stand_on(all_of(world), kTracks, pose_2d(-0.02, 0, 0), {-0.01, 0}, 0).tipped);
  EXPECT_TRUE(stand_on(all_of(world), kTracks, Isometry::Identity(), {0.01, 0}, 0).tipped);
  EXPECT_TRUE(stand_on(all_of(world), kTracks, pose_2d(3, 0, 0), {3, 0}, 0).tipped);
}

}  // namespace
}  // namespace cairn::simulation
