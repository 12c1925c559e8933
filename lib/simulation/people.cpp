// SPDX-License-Identifier: Apache-2.0
#include "simulation/people.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "simulation/random_hash.hpp"

namespace cairn::simulation {
namespace {

constexpr double kMaxStep_s = 0.05;
constexpr double kArrived_m = 0.12;
constexpr double kElbowRoom_m = 0.05;
constexpr double kProgress_m = 0.05;
constexpr double kRadPerDeg = std::numbers::pi / 180;
/// Directions tried off the straight way, the preferred side first.
constexpr std::array<double, 13> kDetours_deg = {0,  15,  -15, 30,  -30, 50, -50,
                                                 70, -70, 90,  -90, 115, 140};

Result<void> check_round(const Person& person, const ReachableFloor& floor,
                         const std::string& key) {
  for (std::size_t i = 0; i < person.waypoints_m.size(); ++i) {
    const Eigen::Vector2d& from = person.waypoints_m[i];
    const Eigen::Vector2d& to = person.waypoints_m[(i + 1) % person.waypoints_m.size()];
    const auto steps = static_cast<int>((to - from).norm() / 0.02) + 1;
    for (int k = 0; k <= steps; ++k) {
      const Eigen::Vector2d at = from + static_cast<double>(k) / steps * (to - from);
      if (floor.has_room_at(at)) continue;
      return fail(key + "waypoints[" + std::to_string(i) +
                  "]: the way to the next one is blocked " + "at (" + std::to_string(at.x()) +
                  ", " + std::to_string(at.y()) + ")");
    }
  }
  return {};
}

}  // namespace

Result<People> People::create(const World& world, std::size_t count, std::uint64_t seed,
                              const Manners& manners) {
  if (count > world.people.size()) {
    return fail("people: " + std::to_string(count) + " are wanted, the world has " +
                std::to_string(world.people.size()));
  }
  People people(seed, manners);
  for (std::size_t i = 0; i < count; ++i) {
    const Person& person = world.people[i];
    const std::string key = "people[" + std::to_string(i) + "].";
    Walker walker;
    walker.radius_m = person.radius_m;
    walker.height_m = person.height_m;
    auto floor = ReachableFloor::flood(world, person.waypoints_m.front(), walker);
    if (!floor) return fail(key + "waypoints[0]: " + floor.error().message);
    if (const auto ok = check_round(person, *floor, key); !ok) {
      return tl::make_unexpected(ok.error());
    }
    Round round;
    round.person = person;
    round.floor = std::make_shared<const ReachableFloor>(std::move(*floor));
    round.waypoint = 1;
    round.nearest_m = std::numeric_limits<double>::infinity();
    people.rounds_.push_back(std::move(round));
    const Eigen::Vector2d way = person.waypoints_m[1] - person.waypoints_m[0];
    people.poses_.push_back({i, person.waypoints_m[0], std::atan2(way.y(), way.x()), 0});
    people.make_up_mind(i);
  }
  return people;
}

void People::step(double dt_s, const Eigen::Vector2d& robot_m, double robot_speed_mps,
                  const TouchesRobot& touches_robot) {
  const bool robot_moves = std::abs(robot_speed_mps) > manners_.stands_mps;
  const int parts = std::max(1, static_cast<int>(std::ceil(dt_s / kMaxStep_s)));
  for (int part = 0; part < parts; ++part) {
    for (std::size_t i = 0; i < rounds_.size(); ++i) {
      walk(i, dt_s / parts, robot_m, robot_moves, touches_robot);
    }
  }
}

void People::walk(std::size_t index, double dt_s, const Eigen::Vector2d& robot_m, bool robot_moves,
                  const TouchesRobot& touches_robot) {
  Round& round = rounds_[index];
  PersonPose& pose = poses_[index];
  Eigen::Vector2d way = round.person.waypoints_m[round.waypoint] - pose.at_m;
  if (way.norm() < kArrived_m) {
    take_next_waypoint(index);
    way = round.person.waypoints_m[round.waypoint] - pose.at_m;
  }
  const double distance_m = way.norm();
  if (distance_m < round.nearest_m - kProgress_m) {
    round.nearest_m = distance_m;
    round.stuck_s = 0;
  }
  const double robot_gap_m = (robot_m - pose.at_m).norm() - round.person.radius_m;
  if (robot_moves && robot_gap_m < manners_.moving_robot_m) return;
  const double step_m = std::min(round.person.speed_mps * dt_s, distance_m);
  const double ahead_rad = std::atan2(way.y(), way.x());
  for (const double detour_deg : kDetours_deg) {
    const double heading_rad = ahead_rad + round.side * detour_deg * kRadPerDeg;
    const Eigen::Vector2d to_m =
        pose.at_m + step_m * Eigen::Vector2d(std::cos(heading_rad), std::sin(heading_rad));
    if (!may_go(index, to_m, robot_m, robot_moves)) continue;
    const PersonPose next{pose.person, to_m, heading_rad, pose.walked_m + step_m};
    if (touches_robot && touches_robot(next)) continue;
    pose = next;
    break;
  }
  round.stuck_s += dt_s;
  if (round.stuck_s > round.patience_s) {
    round.back = !round.back;
    take_next_waypoint(index);
    make_up_mind(index);
  }
}

bool People::may_go(std::size_t index, const Eigen::Vector2d& to_m, const Eigen::Vector2d& robot_m,
                    bool robot_moves) const {
  const Round& round = rounds_[index];
  const Eigen::Vector2d& from_m = poses_[index].at_m;
  if (!round.floor->has_room_at(to_m)) return false;
  // Nearer than allowed only ever by somebody else's doing; then any way out is one.
  const auto too_near = [&](const Eigen::Vector2d& other_m, double allowed_m) {
    const double distance_m = (other_m - to_m).norm();
    return distance_m < allowed_m && distance_m <= (other_m - from_m).norm();
  };
  const double gap_m = robot_moves ? manners_.moving_robot_m : manners_.standing_robot_m;
  if (too_near(robot_m, gap_m + round.person.radius_m)) return false;
  for (std::size_t other = 0; other < rounds_.size(); ++other) {
    if (other == index) continue;
    const double allowed_m = round.person.radius_m + rounds_[other].person.radius_m + kElbowRoom_m;
    if (too_near(poses_[other].at_m, allowed_m)) return false;
  }
  return true;
}

void People::take_next_waypoint(std::size_t index) {
  Round& round = rounds_[index];
  const std::size_t count = round.person.waypoints_m.size();
  round.waypoint = (round.waypoint + (round.back ? count - 1 : 1)) % count;
  round.nearest_m = std::numeric_limits<double>::infinity();
  round.stuck_s = 0;
}

void People::make_up_mind(std::size_t index) {
  Round& round = rounds_[index];
  const std::uint64_t seed = hash64(hash64(seed_, index), round.decisions++);
  round.side = unit_random(hash64(seed, 1)) < 0.5 ? 1 : -1;
  round.patience_s = 2 + 3 * unit_random(hash64(seed, 2));
}

}  // namespace cairn::simulation
