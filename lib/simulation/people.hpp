// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "core/result.hpp"
#include "simulation/person_pose.hpp"
#include "simulation/reachable_floor.hpp"
#include "simulation/world.hpp"

namespace cairn::simulation {

/// How people treat a robot. Distances are from its middle to the circle that holds a person.
struct Manners {
  double standing_robot_m = 0.5;  ///< how near to a robot that stands they come
  double moving_robot_m = 0.7;    ///< how near to one that moves they walk; then they wait
  double stands_mps = 0.02;       ///< a robot slower than this stands
};

/// People on their rounds: each walks from waypoint to waypoint at their speed. They walk round a
/// robot that stands, and turn back if they cannot; they stand still near one that moves; they
/// never walk into walls, things, a robot or each other. A robot that comes nearer by itself finds
/// them standing. The same arguments give the same walks.
class People {
 public:
  /// The first `count` people of the world. Fails where there are fewer, or where somebody's round
  /// is not free.
  [[nodiscard]] static Result<People> create(const World& world, std::size_t count,
                                             std::uint64_t seed, const Manners& manners = {});

  /// Whether somebody who stood so would touch the robot.
  using TouchesRobot = std::function<bool(const PersonPose&)>;

  /// `robot_speed_mps`: of its fastest point, turning included. One whom the robot has come so near
  /// that a leg might touch it walks off only where none does.
  void step(double dt_s, const Eigen::Vector2d& robot_m, double robot_speed_mps,
            const TouchesRobot& touches_robot = {});

  [[nodiscard]] std::span<const PersonPose> poses() const { return poses_; }

 private:
  /// Somebody's mind.
  struct Round {
    Person person;
    std::shared_ptr<const ReachableFloor> floor;
    std::size_t waypoint = 0;  ///< where they walk to
    bool back = false;         ///< through the waypoints the other way round
    double side = 1;           ///< on which side they pass what stands in the way: 1 left, -1 right
    double nearest_m = 0;      ///< to the waypoint so far
    double stuck_s = 0;        ///< for how long they came no nearer
    double patience_s = 3;     ///< after so long they turn back
    std::uint64_t decisions = 0;
  };

  People(std::uint64_t seed, const Manners& manners) : seed_{seed}, manners_{manners} {}
  void walk(std::size_t index, double dt_s, const Eigen::Vector2d& robot_m, bool robot_moves,
            const TouchesRobot& touches_robot);
  [[nodiscard]] bool may_go(std::size_t index, const Eigen::Vector2d& to_m,
                            const Eigen::Vector2d& robot_m, bool robot_moves) const;
  void take_next_waypoint(std::size_t index);
  void make_up_mind(std::size_t index);

  std::uint64_t seed_;
  Manners manners_;
  std::vector<Round> rounds_;
  std::vector<PersonPose> poses_;
};

}  // namespace cairn::simulation
