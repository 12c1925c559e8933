// SPDX-License-Identifier: Apache-2.0
#include "planning/path_follower.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace cairn::planning {
namespace {

constexpr double kStep_s = 1.0 / 15;

/// Tracks that follow commands at once, but for acceleration and slip in turns.
struct Tracks {
  Pose2 pose;
  Drive moving;
  double slip = 0.15;

  void drive(const Drive& wish, double dt_s) {
    moving.forward_mps =
        std::clamp(wish.forward_mps, moving.forward_mps - dt_s, moving.forward_mps + dt_s);
    moving.turn_radps = wish.turn_radps * (1 - slip);
    const double middle_rad = pose.heading_rad + 0.5 * moving.turn_radps * dt_s;
    pose.at_m += moving.forward_mps * dt_s * ahead(middle_rad);
    pose.heading_rad = wrapped_rad(pose.heading_rad + moving.turn_radps * dt_s);
  }
};

PlannedPath path_through(const std::vector<Eigen::Vector2d>& corners, double speed_mps,
                         double room_m) {
  PlannedPath path;
  for (std::size_t i = 1; i < corners.size(); ++i) {
    const Eigen::Vector2d way = corners[i] - corners[i - 1];
    const int count = static_cast<int>(way.norm() / 0.05);
    for (int k = i == 1 ? 0 : 1; k <= count; ++k)
      path.points.push_back({corners[i - 1] + way * k / count, speed_mps, room_m});
  }
  return path;
}

double distance_to_path_m(const PlannedPath& path, const Eigen::Vector2d& at_m) {
  double nearest_m = 1e9;
  for (std::size_t i = 1; i < path.points.size(); ++i) {
    const Eigen::Vector2d a = path.points[i - 1].at_m;
    const Eigen::Vector2d way = path.points[i].at_m - a;
    const double share = std::clamp((at_m - a).dot(way) / way.squaredNorm(), 0.0, 1.0);
    nearest_m = std::min(nearest_m, (a + share * way - at_m).norm());
  }
  return nearest_m;
}

struct Ride {
  Tracks tracks;
  double farthest_m = 0;  ///< from the path
  double fastest_mps = 0;
  double fastest_radps = 0;
  double hardest_mps2 = 0;
  double seconds = 0;
  bool arrived = false;
};

Ride follow(const PlannedPath& path, const Pose2& from, double allowed_mps = 10) {
  PathFollower follower({}, {});
  follower.follow(path);
  Ride ride;
  ride.tracks.pose = from;
  Drive commanded;
  for (; ride.seconds < 120 && !follower.arrived(); ride.seconds += kStep_s) {
    const Drive before = commanded;
    commanded = follower.step(ride.tracks.pose, commanded, kStep_s, {allowed_mps, 10});
    ride.tracks.drive(commanded, kStep_s);
    ride.farthest_m = std::max(ride.farthest_m, distance_to_path_m(path, ride.tracks.pose.at_m));
    ride.fastest_mps = std::max(ride.fastest_mps, std::abs(commanded.forward_mps));
    ride.fastest_radps = std::max(ride.fastest_radps, std::abs(commanded.turn_radps));
    ride.hardest_mps2 =
        std::max(ride.hardest_mps2, std::abs(commanded.forward_mps - before.forward_mps) / kStep_s);
  }
  ride.arrived = follower.arrived();
  return ride;
}

TEST(PathFollower, FollowsAStraightWayAtFullSpeedWithinTheLimits) {
  const auto path = path_through({{0, 0}, {4, 0}}, 0.5, 1);
  const Ride ride = follow(path, {});
  EXPECT_TRUE(ride.arrived);
  EXPECT_LT((ride.tracks.pose.at_m - Eigen::Vector2d(4, 0)).norm(), 0.07);
  EXPECT_GT(ride.fastest_mps, 0.45);
  EXPECT_LE(ride.fastest_mps, 0.5);
  EXPECT_LE(ride.fastest_radps, 1.0);
  EXPECT_LE(ride.hardest_mps2, 1.0 + 1e-9);
  EXPECT_LT(ride.seconds, 14);
}

TEST(PathFollower, CutsNoCornersWhereThereIsNoRoom) {
  const auto path = path_through({{0, 0}, {1.5, 0}, {1.5, 1.5}, {0.5, 1.5}}, 0.15, 0);
  const Ride ride = follow(path, {});
  EXPECT_TRUE(ride.arrived);
  EXPECT_LT(ride.farthest_m, 0.08);
}

TEST(PathFollower, TakesTheHeadingAtTheEnd) {
  auto path = path_through({{0, 0}, {1, 0.5}}, 0.4, 0.5);
  path.heading_rad = -2.5;
  const Ride ride = follow(path, {});
  EXPECT_TRUE(ride.arrived);
  EXPECT_LT(std::abs(wrapped_rad(ride.tracks.pose.heading_rad + 2.5)), 0.12);
  EXPECT_LT((ride.tracks.pose.at_m - Eigen::Vector2d(1, 0.5)).norm(), 0.08);
}

TEST(PathFollower, TurnsOnTheSpotToAWayThatLeadsBack) {
  const auto path = path_through({{0, 0}, {-2, 0}}, 0.4, 0.2);
  const Ride ride = follow(path, {});
  EXPECT_TRUE(ride.arrived);
  EXPECT_LT(ride.farthest_m, 0.1);
}

TEST(PathFollower, GoesNoFasterThanAllowedAndStandsWhereNothingIs) {
  const auto path = path_through({{0, 0}, {2, 0}}, 0.5, 1);
  EXPECT_LE(follow(path, {}, 0.1).fastest_mps, 0.1);
  const Ride held = follow(path, {}, 0);
  EXPECT_FALSE(held.arrived);
  EXPECT_EQ(held.tracks.pose.at_m, Eigen::Vector2d(0, 0));
}

TEST(PathFollower, SlowsDownWhereThePathSaysSo) {
  auto path = path_through({{0, 0}, {3, 0}}, 0.5, 1);
  for (PathPoint& point : path.points) {
    if (point.at_m.x() > 1.5) point.speed_mps = 0.15;
  }
  PathFollower follower({}, {});
  follower.follow(path);
  Tracks tracks;
  Drive commanded;
  while (!follower.arrived()) {
    commanded = follower.step(tracks.pose, commanded, kStep_s, {10, 10});
    tracks.drive(commanded, kStep_s);
    if (tracks.pose.at_m.x() > 1.55) {
      ASSERT_LE(commanded.forward_mps, 0.16);
    }
  }
}

}  // namespace
}  // namespace cairn::planning
