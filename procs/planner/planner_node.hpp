// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cairn/clearance_t.hpp>
#include <cairn/goal_t.hpp>
#include <cairn/odometry_t.hpp>
#include <cairn/pose_t.hpp>
#include <cairn/wheel_state_t.hpp>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bus/node.hpp"
#include "core/config.hpp"
#include "core/robot.hpp"
#include "messages/map_follower.hpp"
#include "planning/navigator.hpp"

namespace cairn {

struct PlannerConfig {
  RobotConfig robot;
  bool explore_at_start = false;
  double max_speed_mps = 0.5;
  double max_turn_radps = 1.0;
  planning::NavigatorConfig navigation;

  void visit(ConfigVisitor& v) {
    v.group("robot", robot, "the robot's size and limits");
    v.flag("explore_at_start", explore_at_start, "begin to explore without being told");
    v.number("max_speed_mps", max_speed_mps, {0.02, 5}, "m/s",
             "never faster, whatever the robot could");
    v.number("max_turn_radps", max_turn_radps, {0.1, 10}, "rad/s", "likewise");
    navigation.visit(v);
  }
};

/// planner: where to go, and how to move now. Explores, drives to goals, gets itself out of
/// trouble. Killed at any moment it goes on with what it was doing.
class PlannerNode {
 public:
  using Config = PlannerConfig;
  static constexpr const char* kName = "planner";
  static constexpr const char* kAbout =
      "planner: explores and drives to goals; turns the map and POSE into DRIVE_COMMAND";

  [[nodiscard]] static Result<std::unique_ptr<PlannerNode>> create(const Config& config,
                                                                   bus::Node& node);

  PlannerNode(const Config& config, bus::Node& node);

  [[nodiscard]] Result<void> finish();

  [[nodiscard]] const planning::Navigator& navigator() const { return navigator_; }

 private:
  void take(const odometry_t& odometry);
  void take(const pose_t& pose);
  void take(const wheel_state_t& wheels);
  void take(const clearance_t& clearance);
  void take(const goal_t& goal);

  [[nodiscard]] planning::Situation situation(const odometry_t& odometry) const;
  [[nodiscard]] bool lost() const;
  void ask_for_map();
  void command();
  void command_if_due();
  void tell_path();
  void tell_state();
  void tell_state_if_new();
  void resume();
  [[nodiscard]] Result<void> remember();

  Config config_;
  bus::Node& node_;
  messages::MapFollower map_;
  planning::Navigator navigator_;
  std::optional<pose_t> pose_;
  Utime sure_utime_ = 0;  ///< of the newest POSE that was sure
  Utime odometry_utime_ = 0;
  HostTime odometry_came_us_ = 0;
  std::optional<clearance_t> clearance_;
  bool latched_ = false;
  HostTime commanded_us_ = 0;
  HostTime moved_us_ = 0;  ///< when last something else than zero was commanded, or was to do
  std::int64_t paths_told_ = 0;
  planning::PlanReport told_;
  std::vector<std::uint8_t> remembered_;
};

}  // namespace cairn
