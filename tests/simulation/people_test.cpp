// SPDX-License-Identifier: Apache-2.0
#include "simulation/people.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "scenes.hpp"

namespace cairn::simulation {
namespace {

constexpr double kStep_s = 0.02;
const Eigen::Vector2d kFarAway(100, 100);
const Manners kManners;

/// A floor of 12 x 6 m with nothing on it but what is given, and one person's round.
World hall(std::vector<BoxConfig> things, const std::vector<Eigen::Vector2d>& waypoints_m) {
  WorldConfig config;
  config.materials.emplace_back().name = "stuff";
  config.boxes = std::move(things);
  config.boxes.push_back(box({0, 0, -0.1}, {12, 6, 0.2}));
  PersonConfig& person = config.people.emplace_back();
  for (const Eigen::Vector2d& at : waypoints_m) person.waypoints.push_back({{at.x(), at.y()}});
  return make_world(config, "hall").value();
}

People people_of(const World& world, std::size_t count = 1, std::uint64_t seed = 1) {
  auto people = People::create(world, count, seed);
  EXPECT_TRUE(people) << people.error().message;
  return std::move(*people);
}

double distance_m(const People& people, const Eigen::Vector2d& point_m) {
  return (people.poses()[0].at_m - point_m).norm();
}

/// Steps until somebody's first person is near a point; false if not within the time.
bool reaches(People& people, const Eigen::Vector2d& point_m, const Eigen::Vector2d& robot_m,
             double time_s) {
  for (double t = 0; t < time_s; t += kStep_s) {
    people.step(kStep_s, robot_m, 0);
    if (distance_m(people, point_m) < 0.2) return true;
  }
  return false;
}

TEST(People, WalkTheirRoundAtTheirSpeed) {
  const std::vector<Eigen::Vector2d> round{{-3, -1}, {3, -1}, {3, 1}};
  const World world = hall({}, round);
  People people = people_of(world);
  EXPECT_EQ(people.poses()[0].at_m, round[0]);
  double time_s = 0;
  for (const std::size_t next : {1U, 2U, 0U, 1U}) {
    while (distance_m(people, round[next]) > 0.15 && time_s < 60) {
      people.step(kStep_s, kFarAway, 0);
      time_s += kStep_s;
    }
  }
  const double way_m = 6 + 2 + std::hypot(6, 2) + 6;
  EXPECT_NEAR(time_s, way_m / world.people[0].speed_mps, 1);
  EXPECT_NEAR(people.poses()[0].walked_m, world.people[0].speed_mps * time_s, 0.05);
}

TEST(People, WalkRoundARobotThatStandsInTheirWay) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const World world = hall({}, {{-3, 0}, {3, 0}});
    People people = people_of(world, 1, seed);
    const Eigen::Vector2d robot(0.05, 0.02);
    double nearest_m = 10;
    double time_s = 0;
    for (; distance_m(people, {3, 0}) > 0.2 && time_s < 20; time_s += kStep_s) {
      people.step(kStep_s, robot, 0);
      nearest_m = std::min(nearest_m, distance_m(people, robot));
    }
    EXPECT_LT(time_s, 12) << seed;
    EXPECT_GE(nearest_m, kManners.standing_robot_m + 0.25);
    EXPECT_LT(nearest_m, kManners.standing_robot_m + 0.35) << "they pass near by";
  }
}

TEST(People, TurnBackWhereARobotStandsInTheOnlyDoor) {
  const World world =
      hall({box({0, 1.75, 1.25}, {0.2, 2.5, 2.5}), box({0, -1.75, 1.25}, {0.2, 2.5, 2.5})},
           {{-3, 0}, {3, 0}});
  People people = people_of(world);
  const Eigen::Vector2d robot(0.3, 0);
  EXPECT_FALSE(reaches(people, {3, 0}, robot, 9));
  EXPECT_TRUE(reaches(people, {-3, 0}, robot, 30));
  // Once it is gone they come through.
  EXPECT_TRUE(reaches(people, {3, 0}, kFarAway, 30));
}

TEST(People, StandStillNearARobotThatMovesUntilItStandsOrIsGone) {
  const World world = hall({}, {{-3, 0}, {3, 0}});
  People people = people_of(world);
  Eigen::Vector2d robot(3, 0.1);
  bool waited = false;
  // It comes towards them, slower and slower, and goes by so near that it would have touched them.
  for (double t = 0; t < 8; t += kStep_s) {
    robot.x() -= 0.5 * kStep_s;
    const Eigen::Vector2d before_m = people.poses()[0].at_m;
    const bool near = (before_m - robot).norm() < kManners.moving_robot_m + 0.25;
    people.step(kStep_s, robot, 0.5);
    if (near) {
      EXPECT_EQ(people.poses()[0].at_m, before_m) << t;
      waited = true;
    }
    if (waited && (before_m - robot).norm() < 0.55) break;
  }
  EXPECT_TRUE(waited);
  // It stands, nearer than they would have come: they leave, and never come nearer on the way.
  double last_m = distance_m(people, robot);
  for (double t = 0; t < 20 && distance_m(people, {3, 0}) > 0.2; t += kStep_s) {
    people.step(kStep_s, robot, 0);
    const double now_m = distance_m(people, robot);
    EXPECT_GE(now_m, std::min(last_m, kManners.standing_robot_m + 0.25) - 1e-9);
    last_m = now_m;
  }
  EXPECT_LT(distance_m(people, {3, 0}), 0.3);
  // Gone, they walk on.
  const double walked_m = people.poses()[0].walked_m;
  for (int i = 0; i < 50; ++i) people.step(kStep_s, kFarAway, 0.5);
  EXPECT_GT(people.poses()[0].walked_m, walked_m + 0.5);
}

class PeopleOf : public testing::TestWithParam<const char*> {};

TEST_P(PeopleOf, NeverWalkIntoWallsThingsEachOtherOrAStandingRobot) {
  const auto world = load_world(world_file(GetParam()));
  ASSERT_TRUE(world) << world.error().message;
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    People people = people_of(*world, world->people.size(), seed);
    std::mt19937 random(static_cast<unsigned>(seed));
    Eigen::Vector2d robot = world->T_world_start.translation().head<2>();
    bool moves = false;
    for (int i = 0; i < 6000; ++i) {
      // The robot stands and jumps to another place by turns; the jump is a drive.
      if (i % 500 == 0) {
        moves = !moves;
        if (moves) robot = free_pose(*world, 0.28, random).translation().head<2>();
      }
      std::vector<PersonPose> before(people.poses().begin(), people.poses().end());
      people.step(0.05, robot, moves ? 0.3 : 0);
      for (std::size_t a = 0; a < before.size(); ++a) {
        const Person& person = world->people[a];
        const Eigen::Vector2d& at = people.poses()[a].at_m;
        for (double z_m = person.radius_m + 0.01; z_m < person.height_m - 0.2; z_m += 0.1) {
          ASSERT_GT(world->distance_m({at.x(), at.y(), z_m}), person.radius_m - 0.015)
              << at.transpose() << " seed " << seed << " step " << i;
        }
        const double robot_m = (at - robot).norm();
        ASSERT_GE(robot_m, std::min((before[a].at_m - robot).norm(),
                                    kManners.standing_robot_m + person.radius_m) -
                               1e-9);
        for (std::size_t b = 0; b < a; ++b) {
          ASSERT_GE((at - people.poses()[b].at_m).norm(),
                    person.radius_m + world->people[b].radius_m);
        }
      }
    }
    for (std::size_t a = 0; a < people.poses().size(); ++a) {
      EXPECT_GT(people.poses()[a].walked_m, 0.25 * 300 * world->people[a].speed_mps)
          << world->people[a].name << " hardly walked, seed " << seed;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Worlds, PeopleOf,
                         testing::Values("room", "apartment", "office", "hand-drawn",
                                         "symmetric-room", "plain"),
                         [](const auto& world) {
                           std::string name = world.param;
                           std::erase(name, '-');
                           return name;
                         });

TEST(People, TheSameSeedGivesTheSameWalks) {
  const auto world = load_world(world_file("room"));
  ASSERT_TRUE(world) << world.error().message;
  const auto walk = [&](std::uint64_t seed) {
    People people = people_of(*world, 2, seed);
    for (int i = 0; i < 5000; ++i) people.step(kStep_s, {0.5, 0.9}, i % 300 < 100 ? 0.2 : 0);
    return people.poses()[0].at_m;
  };
  EXPECT_EQ(walk(1), walk(1));
  EXPECT_NE(walk(1), walk(2));
}

TEST(People, RoundsThatAreNotFreeAreRefused) {
  const auto error_of = [](const World& world, std::size_t count) {
    const auto people = People::create(world, count, 1);
    return people ? std::string("no error") : people.error().message;
  };
  const World empty = hall({}, {{-3, 0}, {3, 0}});
  EXPECT_EQ(error_of(empty, 1), "no error");
  EXPECT_EQ(error_of(empty, 0), "no error");
  EXPECT_EQ(error_of(empty, 2), "people: 2 are wanted, the world has 1");
  const World blocked = hall({box({1, 0.2, 0.5}, {0.5, 0.5, 1})}, {{-3, 0}, {3, 0}});
  EXPECT_EQ(error_of(blocked, 1).find("people[0].waypoints[0]: the way to the next one is blocked"),
            0U);
  const World outside = hall({}, {{-9, 0}, {3, 0}});
  EXPECT_EQ(error_of(outside, 1).find("people[0].waypoints[0]: floor: nothing of radius"), 0U);
  const World thin = hall({box({1, 0.2, 0.5}, {0.03, 0.03, 1})}, {{-3, 0}, {3, 0}});
  EXPECT_NE(error_of(thin, 1), "no error");
}

}  // namespace
}  // namespace cairn::simulation
