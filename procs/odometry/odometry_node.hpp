// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cairn/wheel_state_t.hpp>
#include <deque>
#include <memory>

#include "bus/node.hpp"
#include "core/config.hpp"
#include "core/robot.hpp"
#include "messages/rectified_frames.hpp"
#include "odometry/stereo_odometry.hpp"
#include "odometry/track_kinematics.hpp"

namespace cairn {

struct OdometryConfig {
  bool visual = true;
  odometry::StereoOdometryConfig sight;
  odometry::TrackConfig tracks;
  RobotConfig robot;

  void visit(ConfigVisitor& v) {
    v.flag("visual", visual, "false: reckons by the tracks alone and does not look");
    sight.visit(v);
    v.group("tracks", tracks, "how the tracks move the body");
    v.group("robot", robot, "the robot's size and limits");
  }
};

/// odometry: how the robot moves, by its eyes and its tracks. ODOMETRY(k) rests on STEREO_FRAME k
/// and every WHEEL_STATE up to 40 ms before it, whenever they arrive: a frame waits for them until
/// the tracks have been silent for 200 ms of data time. A restarted process goes on from the pose,
/// the velocity and the ticks of its last frame, in a new epoch.
class OdometryNode {
 public:
  using Config = OdometryConfig;
  static constexpr const char* kName = "odometry";
  static constexpr const char* kAbout =
      "odometry: turns STEREO_FRAME and WHEEL_STATE into ODOMETRY";

  [[nodiscard]] static Result<std::unique_ptr<OdometryNode>> create(const Config& config,
                                                                    bus::Node& node);

  OdometryNode(const Config& config, bus::Node& node);

  [[nodiscard]] Result<void> finish() { return {}; }

 private:
  void resume();
  void remember();
  void take(const stereo_frame_t& frame);
  void take(const wheel_state_t& wheels);
  void work_off();
  void update(const stereo_frame_t& frame);
  [[nodiscard]] Result<odometry::OdometryEstimate> estimate(const stereo_frame_t& frame);
  void count(const odometry::OdometryEstimate& estimate);

  Config config_;
  bus::Node& node_;
  messages::RectifiedFrames frames_;
  odometry::TrackHistory tracks_;
  odometry::StereoOdometry odometry_;
  std::deque<stereo_frame_t> waiting_;
  Utime answered_utime_ = 0;  ///< of the newest frame that was answered
};

}  // namespace cairn
