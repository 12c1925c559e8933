// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>

#include "camera/frame_source.hpp"
#include "camera/v4l2_camera.hpp"

namespace cairn::camera {

/// Two webcams as one source. Nothing is opened before the first next(); a device that is out
/// (unplugged, input error, no frame in time) is an error, both are closed, and the next call opens
/// them again: the caller sets the pace. next() returns within timeout_ms, besides what opening
/// takes.
class V4l2Pair : public FrameSource {
 public:
  /// `utime_offset_us` added to the kernel's monotonic time gives data time. An error if rig and
  /// config disagree.
  [[nodiscard]] static Result<std::unique_ptr<V4l2Pair>> create(
      const V4l2Config& config, const RigCalibration& rig, std::unique_ptr<V4l2Device> left,
      std::unique_ptr<V4l2Device> right, MonotonicClock clock, std::int64_t utime_offset_us);

  [[nodiscard]] const RigCalibration& rig() const override { return rig_; }
  [[nodiscard]] double rate_hz() const override { return left_.rate_hz(); }
  [[nodiscard]] bool finished() const override { return false; }

  /// A frame's utime is the left camera's. Images further apart than max_skew_ms are no pair: the
  /// older is dropped and its camera's next one tried, a few times over, then it is an error. So is
  /// an image that is cut off or damaged.
  [[nodiscard]] Result<Frame> next() override;

  /// Pairs refused because left and right were too far apart.
  [[nodiscard]] std::int64_t skew_refused() const { return skew_refused_; }

 private:
  V4l2Pair(const V4l2Config& config, const RigCalibration& rig, std::unique_ptr<V4l2Device> left,
           std::unique_ptr<V4l2Device> right, MonotonicClock clock, std::int64_t utime_offset_us);

  [[nodiscard]] Result<void> start();
  void stop();
  /// False: they are out of step beyond the tries of one call.
  [[nodiscard]] Result<bool> grab_pair();
  [[nodiscard]] Result<void> grab(V4l2Camera& camera, HostTime deadline);
  [[nodiscard]] std::int64_t skew_us() const { return left_.grabbed_at() - right_.grabbed_at(); }
  [[nodiscard]] Result<Frame> retrieve_pair();
  [[nodiscard]] Result<void> check_time() const;

  V4l2Config config_;
  RigCalibration rig_;
  V4l2Camera left_;
  V4l2Camera right_;
  MonotonicClock clock_;
  std::int64_t utime_offset_us_;
  bool running_ = false;
  bool seen_since_start_ = false;
  HostTime started_at_ = 0;
  HostTime last_at_ = INT64_MIN;
  std::int64_t index_ = 0;
  std::int64_t skew_refused_ = 0;
};

}  // namespace cairn::camera
