// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "bus/node.hpp"
#include "camera/frame_source.hpp"
#include "camera/v4l2_config.hpp"
#include "core/config.hpp"
#include "messages/image_messages.hpp"

namespace cairn {

struct CameraConfig {
  std::string source = "v4l2";
  std::string dataset;
  std::string video_left;
  std::string video_right;
  std::string rig;
  camera::V4l2Config v4l2;
  double speed = 1;
  std::string encoding = "jpeg";
  int frame_budget_bytes = messages::FrameEncoder::kDefaultBudget_bytes;
  int depth_step_px = 2;

  void visit(ConfigVisitor& v) {
    v.choice("source", source, {"v4l2", "video", "dataset"}, "where the frames come from");
    v.text("dataset", dataset,
           "folder: one with a dataset.yaml, a EuRoC folder (mav0) or a KITTI odometry sequence");
    v.text("video_left", video_left, "left video file, for source video");
    v.text("video_right", video_right, "right video file, for source video");
    v.text("rig", rig, "calibration file of the two cameras, for source v4l2 and video");
    v.group("v4l2", v4l2, "the two webcams, for source v4l2");
    v.number("speed", speed, {0.01, 100}, "",
             "how many times faster than life a recording is played");
    v.choice("encoding", encoding, {"jpeg", "raw"}, "how images go over the bus");
    v.integer("frame_budget_bytes", frame_budget_bytes, 10'000, 50'000'000, "bytes",
              "the JPEG quality of each frame is chosen to fit this; over 115000 a stock kernel "
              "loses frames");
    v.integer("depth_step_px", depth_step_px, 1, 8, "px",
              "a depth recording is published at every so-many-th pixel");
  }
};

/// camera: the robot's eyes. Publishes each capture as STEREO_FRAME (of a depth recording:
/// DISPARITY of a virtual rig), the rig as CALIBRATION, and the data time as CLOCK. A recording is
/// played once, at its own rate times `speed`; a restarted process goes on after the last frame
/// that it published.
class CameraNode {
 public:
  using Config = CameraConfig;
  static constexpr const char* kName = "camera";
  static constexpr const char* kAbout =
      "camera: publishes what two webcams, two videos or a dataset saw (STEREO_FRAME, CALIBRATION, "
      "CLOCK)";

  /// An error names the key, file or device that does not serve.
  [[nodiscard]] static Result<std::unique_ptr<CameraNode>> create(const Config& config,
                                                                  bus::Node& node);

  CameraNode(const Config& config, std::unique_ptr<camera::FrameSource> source, bus::Node& node);

  [[nodiscard]] Result<void> finish() { return {}; }

  [[nodiscard]] std::int64_t published() const { return published_; }

 private:
  void resume();
  void remember(std::int64_t next_index);
  void publish_calibration();
  void publish_clock(Utime utime);
  void tick_between_frames();
  void publish_next_frame();
  void take_error(const std::string& why);
  [[nodiscard]] std::uint64_t recording_id() const;
  [[nodiscard]] bool publish_frame(const camera::Frame& frame);
  [[nodiscard]] bool publish_stereo(const camera::Frame& frame);
  [[nodiscard]] bool publish_depth(const camera::Frame& frame);

  Config config_;
  std::unique_ptr<camera::FrameSource> source_;
  bus::Node& node_;
  camera::RigCalibration rig_;
  messages::FrameEncoder encoder_;
  std::optional<Utime> last_utime_;
  HostTime last_frame_host_us_ = 0;
  HostTime retry_us_ = 0;  ///< when a live camera that failed is tried again
  std::int64_t published_ = 0;
};

}  // namespace cairn
