// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cairn/disparity_t.hpp>
#include <cairn/range_t.hpp>
#include <cairn/wheel_state_t.hpp>
#include <deque>
#include <memory>

#include "bus/node.hpp"
#include "core/config.hpp"
#include "core/robot.hpp"
#include "odometry/track_kinematics.hpp"
#include "planning/clearance.hpp"

namespace cairn {

struct GuardConfig {
  RobotConfig robot;
  odometry::TrackConfig tracks;
  planning::ClearanceConfig clearance;
  double max_sight_age_s = 0.4;
  double max_wheel_age_s = 0.25;

  void visit(ConfigVisitor& v) {
    v.group("robot", robot, "the robot's size and limits");
    v.group("tracks", tracks, "how the tracks move the body");
    v.group("clearance", clearance, "what must be seen of the ground ahead");
    v.number("max_sight_age_s", max_sight_age_s, {0.05, 5}, "s",
             "with a newest DISPARITY older than this (data time) nothing is allowed");
    v.number("max_wheel_age_s", max_wheel_age_s, {0.05, 5}, "s",
             "with a newest WHEEL_STATE older than this (data time) nothing is allowed");
  }
};

/// guard: permission to move forward, whoever drives. Knows no map and no pose; keeps nothing over
/// a restart: it allows nothing until it has seen again.
class GuardNode {
 public:
  using Config = GuardConfig;
  static constexpr const char* kName = "guard";
  static constexpr const char* kAbout =
      "guard: turns DISPARITY, WHEEL_STATE and RANGE into CLEARANCE, permission to move forward";

  [[nodiscard]] static Result<std::unique_ptr<GuardNode>> create(const Config& config,
                                                                 bus::Node& node);

  GuardNode(const Config& config, bus::Node& node);

  [[nodiscard]] Result<void> finish() { return {}; }

 private:
  void take(const disparity_t& seen);
  void take(const wheel_state_t& wheels);
  void take(const range_t& range);
  void look_at_what_is_ready();
  void look_at(const stereo::DisparityImage& image);
  void stand_on(const odometry::TrackHistory::Moment& moment);
  [[nodiscard]] planning::Permission permission() const;
  void publish();

  Config config_;
  bus::Node& node_;
  odometry::TrackHistory tracks_;
  planning::Clearance clearance_;
  std::deque<stereo::DisparityImage> waiting_;
  std::int64_t chain_ = 0;  ///< that the memory of the ground belongs to
  Utime seen_utime_ = 0;    ///< of the newest image looked at; 0: none
  double commanded_turn_radps_ = 0;
};

}  // namespace cairn
