// SPDX-License-Identifier: Apache-2.0
#include "simulation/tracked_body.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "scenes.hpp"
#include "simulation/person_look.hpp"

namespace cairn::simulation {
namespace {

constexpr double kStep_s = 0.005;
constexpr double kRadPerDeg = std::numbers::pi / 180;
const RobotConfig kRobot;

TracksConfig without_slip() {
  TracksConfig tracks;
  tracks.left_slip = 0;
  tracks.right_slip = 0;
  tracks.slip_noise = 0;
  return tracks;
}

BoxConfig wide_floor() { return box({0, 0, -0.1}, {40, 40, 0.2}); }

TrackedBody body_in(World world, const TracksConfig& tracks = without_slip(),
                    std::uint64_t seed = 1) {
  auto body =
      TrackedBody::create(std::make_shared<const World>(std::move(world)), kRobot, tracks, seed);
  EXPECT_TRUE(body) << body.error().message;
  return std::move(*body);
}

void drive(TrackedBody& body, double left, double right, double time_s,
           std::span<const PersonPose> people = {}) {
  for (int i = 0; i < std::lround(time_s / kStep_s); ++i) body.step(left, right, kStep_s, people);
}

/// Way of a track from a standing start at a constant duty: the integral of a first-order answer.
double way_m(double duty, double time_s, const TracksConfig& tracks) {
  const double tau = tracks.time_constant_s;
  return duty * tracks.full_duty_mps * (time_s - tau * (1 - std::exp(-time_s / tau)));
}

TEST(TrackedBody, DrivesTheArcOfADifferentialDrive) {
  const TracksConfig tracks = without_slip();
  for (const auto& [left, right] :
       {std::pair{0.3, 0.5}, {0.5, 0.3}, {-0.4, 0.4}, {0.4, 0.4}, {-0.2, -0.5}, {0.0, 0.3}}) {
    TrackedBody body = body_in(world_of({wide_floor()}));
    constexpr double kTime_s = 2.77;
    drive(body, left, right, kTime_s);
    const double gauge_m = kRobot.track_gauge_m * tracks.effective_gauge_ratio;
    const double left_m = way_m(left, kTime_s, tracks);
    const double right_m = way_m(right, kTime_s, tracks);
    const double turn = (right_m - left_m) / gauge_m;
    Eigen::Vector2d at(0.5 * (left_m + right_m), 0);
    if (std::abs(turn) > 1e-9) {
      const double radius_m = 0.5 * (left_m + right_m) / turn;
      at = radius_m * Eigen::Vector2d(std::sin(turn), 1 - std::cos(turn));
    }
    EXPECT_NEAR((body.T_world_body().translation().head<2>() - at).norm(), 0, 1e-9)
        << left << " " << right;
    EXPECT_NEAR(std::remainder(yaw_rad(body.T_world_body()) - turn, 2 * std::numbers::pi), 0, 1e-9);
    EXPECT_EQ(body.left_ticks(), std::floor(left_m * kRobot.ticks_per_m));
    EXPECT_EQ(body.right_ticks(), std::floor(right_m * kRobot.ticks_per_m));
  }
}

TEST(TrackedBody, LosesTheShareThatSlips) {
  TracksConfig tracks = without_slip();
  tracks.left_slip = 0.3;
  TrackedBody body = body_in(world_of({wide_floor()}), tracks);
  drive(body, 0.5, 0.5, 2);
  const double way = way_m(0.5, 2, tracks);
  const double turn = 0.3 * way / (kRobot.track_gauge_m * tracks.effective_gauge_ratio);
  EXPECT_NEAR(yaw_rad(body.T_world_body()), turn, 1e-9);
  EXPECT_EQ(body.left_ticks(), body.right_ticks());
  const double gauge_share = 0.15 / tracks.effective_gauge_ratio;
  EXPECT_NEAR(body.left_hold().slip, 0.15 + gauge_share, 1e-3);
  EXPECT_NEAR(body.right_hold().slip, 0.15 - gauge_share, 1e-3);
}

TEST(TrackedBody, SlipWandersAroundItsMeanAsMuchAsItIsTold) {
  TracksConfig tracks = without_slip();
  tracks.left_slip = 0.1;
  tracks.right_slip = 0.1;
  tracks.slip_noise = 0.04;
  constexpr int kRuns = 400;
  double sum = 0;
  double sum_of_squares = 0;
  for (int run = 0; run < kRuns; ++run) {
    TrackDrive track(tracks, tracks.left_slip, static_cast<std::uint64_t>(run));
    for (int i = 0; i < 400; ++i) track.step(0.5, kStep_s);
    const double slip = 1 - track.ground_mps() / track.mps();
    sum += slip;
    sum_of_squares += slip * slip;
  }
  const double mean = sum / kRuns;
  const double deviation = std::sqrt(sum_of_squares / kRuns - mean * mean);
  EXPECT_NEAR(mean, 0.1, 4 * 0.04 / std::sqrt(kRuns));
  EXPECT_NEAR(deviation, 0.04, 4 * 0.04 / std::sqrt(2 * kRuns));
}

TEST(TrackedBody, StallsAtAWallWhileItsTracksSlip) {
  World world = world_of({wide_floor(), box({1.05, 0, 0.5}, {0.1, 6, 1})});
  world.boxes[1].name = "wall";
  TrackedBody body = body_in(std::move(world));
  EXPECT_EQ(body.last_collision(), "");
  drive(body, 0.5, 0.5, 5);
  EXPECT_NEAR(body.T_world_body().translation().x(), 1 - 0.5 * kRobot.length_m, 1e-4);
  EXPECT_EQ(body.left_ticks(), std::floor(way_m(0.5, 5, without_slip()) * kRobot.ticks_per_m));
  EXPECT_NEAR(body.left_hold().ground_mps, 0, 1e-6);
  EXPECT_NEAR(body.right_hold().slip, 1, 1e-6);
  EXPECT_EQ(body.contacts(), 1);
  EXPECT_EQ(body.collisions(), 1);
  EXPECT_EQ(body.last_collision(), "wall");
}

TEST(TrackedBody, CountsEachRunAgainstAWallOnce) {
  TrackedBody body = body_in(world_of({wide_floor(), box({1.05, 0, 0.5}, {0.1, 6, 1})}));
  for (int time = 1; time <= 3; ++time) {
    drive(body, 0.4, 0.4, 5);
    EXPECT_EQ(body.collisions(), time);
    EXPECT_EQ(body.contacts(), 1);
    drive(body, -0.4, -0.4, 1);
    EXPECT_EQ(body.contacts(), 0);
  }
}

TEST(TrackedBody, TouchingSlowlyIsNoCollision) {
  World world = world_of({wide_floor(), box({0.3, 0, 0.5}, {0.1, 6, 1})});
  TrackedBody body = body_in(std::move(world));
  const double duty = 0.8 * TrackedBody::kCollision_mps / without_slip().full_duty_mps;
  drive(body, duty, duty, 5);
  EXPECT_EQ(body.contacts(), 1);
  EXPECT_EQ(body.collisions(), 0);
}

TEST(TrackedBody, SlidesAlongAWallThatItMeetsAtASlant) {
  World world = world_of({wide_floor(), box({0, 1.05, 0.5}, {20, 0.1, 1})});
  world.T_world_start = pose_2d(0, 0.5, 20 * kRadPerDeg);
  TrackedBody body = body_in(std::move(world));
  drive(body, 0.5, 0.5, 6);
  EXPECT_GT(body.T_world_body().translation().x(), 1.5);
  EXPECT_EQ(body.collisions(), 1);
  EXPECT_NEAR(yaw_rad(body.T_world_body()), 20 * kRadPerDeg, 1e-9);
}

TEST(TrackedBody, TurnsOutOfAWallThatItsCornerMeets) {
  World world = world_of({wide_floor(), box({0, 0.22, 0.5}, {20, 0.1, 1})});
  TrackedBody body = body_in(std::move(world));
  drive(body, -0.4, 0.4, 3);
  EXPECT_GE(body.collisions(), 1);
  const double corner_m = 0.5 * std::hypot(kRobot.length_m, kRobot.width_m);
  EXPECT_NEAR(body.T_world_body().translation().y(), 0.17 - corner_m, 0.003);
}

/// A floor, and a ramp that rises along x from x = 1, z = 0.
World ramp_world(double slope_deg) {
  const double slope = slope_deg * kRadPerDeg;
  const Eigen::Vector3d middle = Eigen::Vector3d(1, 0, 0) +
                                 2 * Eigen::Vector3d(std::cos(slope), 0, std::sin(slope)) -
                                 0.1 * Eigen::Vector3d(-std::sin(slope), 0, std::cos(slope));
  return world_of(
      {wide_floor(), box({middle.x(), 0, middle.z()}, {4, 4, 0.2}, {0, -slope_deg, 0})});
}

TEST(TrackedBody, ClimbsARampToItsHeightAtItsPitch) {
  for (const double slope_deg : {5.0, 10.0}) {
    const double slope = slope_deg * kRadPerDeg;
    TrackedBody body = body_in(ramp_world(slope_deg));
    double before_m = 0;
    for (int i = 0; i < 1500 && body.T_world_body().translation().x() < 2; ++i) {
      before_m = body.T_world_body().translation().x();
      drive(body, 0.5, 0.5, kStep_s);
    }
    const Eigen::Vector3d at = body.T_world_body().translation();
    ASSERT_GE(at.x(), 2);
    EXPECT_NEAR(at.z(), (at.x() - 1) * std::tan(slope), 1e-9);
    EXPECT_NEAR(std::asin(body.T_world_body().linear()(2, 0)), slope, 1e-9);
    EXPECT_NEAR(at.x() - before_m, 0.4 * kStep_s * std::cos(slope), 1e-6);
    EXPECT_EQ(body.contacts(), 0);
    drive(body, -0.5, -0.5, 8);
    EXPECT_NEAR(body.T_world_body().translation().z(), 0, 1e-9);
    EXPECT_EQ(body.collisions(), 0);
  }
}

TEST(TrackedBody, ClimbsAStepOfTwoCentimetresAndStopsAtThree) {
  TrackedBody over = body_in(world_of({wide_floor(), box({2, 0, 0.01}, {2, 4, 0.02})}));
  drive(over, 0.5, 0.5, 5);
  EXPECT_NEAR(over.T_world_body().translation().z(), 0.02, 1e-9);
  EXPECT_EQ(over.contacts(), 0);
  TrackedBody stopped = body_in(world_of({wide_floor(), box({2, 0, 0.015}, {2, 4, 0.03})}));
  drive(stopped, 0.5, 0.5, 5);
  EXPECT_NEAR(stopped.T_world_body().translation().x(), 1 - 0.5 * kRobot.length_m, 1e-4);
  EXPECT_EQ(stopped.collisions(), 1);
}

TEST(TrackedBody, PassesUnderWhatIsHigherThanItself) {
  TrackedBody under = body_in(world_of({wide_floor(), box({2, 0, 0.46}, {1, 1, 0.1})}));
  drive(under, 0.5, 0.5, 8);
  EXPECT_GT(under.T_world_body().translation().x(), 3);
  TrackedBody stopped = body_in(world_of({wide_floor(), box({2, 0, 0.44}, {1, 1, 0.1})}));
  drive(stopped, 0.5, 0.5, 8);
  EXPECT_NEAR(stopped.T_world_body().translation().x(), 1.5 - 0.5 * kRobot.length_m, 1e-4);
}

TEST(TrackedBody, FallsOverAnEdgeAndMovesNoMore) {
  TrackedBody body = body_in(world_of({box({0, 0, -0.1}, {2, 2, 0.2})}));
  drive(body, 0.5, 0.5, 5);
  EXPECT_TRUE(body.fallen());
  EXPECT_NEAR(body.T_world_body().translation().x(), 1, 0.003);
  EXPECT_EQ(body.contacts(), 1);
  EXPECT_EQ(body.collisions(), 1);
  const Isometry there = body.T_world_body();
  drive(body, -0.5, -0.5, 2);
  EXPECT_EQ(body.T_world_body().matrix(), there.matrix());
  EXPECT_EQ(body.collisions(), 1);
}

TEST(TrackedBody, IsStoppedBySomebodysLegsAndPassesBesideThem) {
  World world = world_of({wide_floor()});
  world.people.push_back({"somebody", 1, 0.25, 1.7, {{0, 0}, {1, 0}}});
  const Person person = world.people[0];
  // Both legs stand upright, as far forward as each other.
  const Box leg = person_boxes(person, {0, {1, 0}, 0, 0})[0];
  TrackedBody body = body_in(world);
  const std::vector<PersonPose> before{{0, {1, 0}, 0, 0}};
  drive(body, 0.5, 0.5, 5, before);
  EXPECT_NEAR(body.T_world_body().translation().x(),
              1 - leg.half_size_m.x() - 0.5 * kRobot.length_m, 1e-4);
  EXPECT_EQ(body.collisions(), 1);
  EXPECT_EQ(body.contacts(), 1);

  const double legs_m = leg.T_world_box.translation().y() + leg.half_size_m.y();
  ASSERT_LT(legs_m + 0.02, person.radius_m);
  TrackedBody passing = body_in(world);
  const std::vector<PersonPose> beside{{0, {1, 0.5 * kRobot.width_m + legs_m + 0.02}, 0, 0}};
  drive(passing, 0.5, 0.5, 5, beside);
  EXPECT_GT(passing.T_world_body().translation().x(), 1.5);
  EXPECT_EQ(passing.collisions(), 0);
}

TEST(TrackedBody, StaysOutOfANotchThatIsTooNarrow) {
  World world = world_of({wide_floor(), box({1.5, 0.6, 0.5}, {1.4, 1, 1}, {0, 0, 15}),
                          box({1.5, -0.6, 0.5}, {1.4, 1, 1}, {0, 0, -15})});
  TrackedBody body = body_in(std::move(world));
  drive(body, 0.5, 0.5, 6);
  EXPECT_GE(body.collisions(), 1);
  EXPECT_NEAR(body.left_hold().ground_mps, 0, 1e-6);
}

TEST(TrackedBody, IsTheSameForTheSameSeedAndAnotherForAnother) {
  TracksConfig tracks;
  TrackedBody one = body_in(load_world(room_file()).value(), tracks, 3);
  TrackedBody same = body_in(load_world(room_file()).value(), tracks, 3);
  TrackedBody other = body_in(load_world(room_file()).value(), tracks, 4);
  for (int i = 0; i < 2000; ++i) {
    const double left = 0.5 * std::sin(0.01 * i);
    const double right = 0.5 * std::cos(0.013 * i);
    for (TrackedBody* body : {&one, &same, &other}) body->step(left, right, kStep_s, {});
    ASSERT_EQ(one.T_world_body().matrix(), same.T_world_body().matrix()) << i;
  }
  EXPECT_NE(one.T_world_body().matrix(), other.T_world_body().matrix());
}

TEST(TrackedBody, DoesNotStartInSomethingNorWhereNothingCarriesIt) {
  const auto create = [](World world) {
    return TrackedBody::create(std::make_shared<const World>(std::move(world)), kRobot, {}, 1);
  };
  World inside = world_of({wide_floor(), box({0.2, 0, 0.5}, {0.2, 0.2, 1})});
  inside.boxes[1].name = "pillar";
  const auto in_something = create(inside);
  ASSERT_FALSE(in_something);
  EXPECT_NE(in_something.error().message.find("pillar"), std::string::npos);
  World floating = world_of({wide_floor()});
  floating.T_world_start = pose_2d(30, 0, 0);
  const auto in_the_air = create(floating);
  ASSERT_FALSE(in_the_air);
  EXPECT_NE(in_the_air.error().message.find("start.at_m"), std::string::npos);
}

}  // namespace
}  // namespace cairn::simulation
