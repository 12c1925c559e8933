// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "bus/node.hpp"
#include "messages/rectified_frames.hpp"
#include "odometry/stereo_odometry.hpp"

namespace cairn {

/// odometry: how the robot moves. Turns each STEREO_FRAME into ODOMETRY. A restarted process goes
/// on from the pose and the velocity of its last frame, in a new epoch.
class OdometryNode {
 public:
  using Config = odometry::StereoOdometryConfig;
  static constexpr const char* kName = "odometry";
  static constexpr const char* kAbout = "odometry: turns STEREO_FRAME into ODOMETRY";

  [[nodiscard]] static Result<std::unique_ptr<OdometryNode>> create(const Config& config,
                                                                    bus::Node& node);

  OdometryNode(const Config& config, bus::Node& node);

  [[nodiscard]] Result<void> finish() { return {}; }

 private:
  void resume();
  void remember();
  void update(const stereo_frame_t& frame);

  bus::Node& node_;
  messages::RectifiedFrames frames_;
  odometry::StereoOdometry odometry_;
};

}  // namespace cairn
