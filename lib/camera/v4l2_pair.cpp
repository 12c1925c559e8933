// SPDX-License-Identifier: Apache-2.0
#include "camera/v4l2_pair.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <utility>

namespace cairn::camera {
namespace {

constexpr int kSkewTries = 8;
constexpr std::int64_t kMaxAge_us = kMicrosecondsPerSecond;

std::string ms_text(std::int64_t duration_us) {
  return std::to_string(duration_us / 1000) + "." + std::to_string(duration_us % 1000 / 100) +
         " ms";
}

}  // namespace

Result<std::unique_ptr<V4l2Pair>> V4l2Pair::create(
    const V4l2Config& config, const RigCalibration& rig, std::unique_ptr<V4l2Device> left,
    std::unique_ptr<V4l2Device> right, MonotonicClock clock, std::int64_t utime_offset_us) {
  if (const auto checked = check(rig); !checked) {
    return fail("the calibration: " + checked.error().message);
  }
  if (config.width_px != rig.width_px || config.height_px != rig.height_px) {
    return fail("width_px, height_px: " + std::to_string(config.width_px) + " x " +
                std::to_string(config.height_px) + ", but the rig is calibrated for " +
                std::to_string(rig.width_px) + " x " + std::to_string(rig.height_px));
  }
  if (config.left_device == config.right_device) {
    return fail("left_device, right_device: are both " + config.left_device);
  }
  return std::unique_ptr<V4l2Pair>(new V4l2Pair(config, rig, std::move(left), std::move(right),
                                                std::move(clock), utime_offset_us));
}

V4l2Pair::V4l2Pair(const V4l2Config& config, const RigCalibration& rig,
                   std::unique_ptr<V4l2Device> left, std::unique_ptr<V4l2Device> right,
                   MonotonicClock clock, std::int64_t utime_offset_us)
    : config_{config},
      rig_{rig},
      left_{"left", config.left_device, config, std::move(left)},
      right_{"right", config.right_device, config, std::move(right)},
      clock_{std::move(clock)},
      utime_offset_us_{utime_offset_us} {}

Result<Frame> V4l2Pair::next() {
  if (auto started = start(); !started) return tl::make_unexpected(started.error());
  const auto paired = grab_pair();
  if (!paired) return tl::make_unexpected(paired.error());
  if (!*paired) {
    return fail(left_.name() + " and " + right_.name() + ": are " + ms_text(std::abs(skew_us())) +
                " apart, max_skew_ms is " + ms_text(std::llround(config_.max_skew_ms * 1000)));
  }
  auto frame = retrieve_pair();
  last_at_ = std::max(last_at_, left_.grabbed_at());
  for (V4l2Camera* camera : {&left_, &right_}) {
    if (auto released = camera->release(); !released) {
      stop();
      return tl::make_unexpected(released.error());
    }
  }
  return frame;
}

Result<void> V4l2Pair::start() {
  if (running_) return {};
  for (V4l2Camera* camera : {&left_, &right_}) {
    if (auto started = camera->start(); !started) {
      stop();
      return started;
    }
  }
  running_ = true;
  seen_since_start_ = false;
  started_at_ = clock_();
  return {};
}

void V4l2Pair::stop() {
  left_.stop();
  right_.stop();
  running_ = false;
}

Result<bool> V4l2Pair::grab_pair() {
  const HostTime deadline = clock_() + std::int64_t{config_.timeout_ms} * 1000;
  const std::int64_t max_skew_us = std::llround(config_.max_skew_ms * 1000);
  for (int tries = 0; tries < kSkewTries; ++tries) {
    for (V4l2Camera* camera : {&left_, &right_}) {
      if (auto grabbed = grab(*camera, deadline); !grabbed) {
        return tl::make_unexpected(grabbed.error());
      }
    }
    seen_since_start_ = true;
    if (std::abs(skew_us()) <= max_skew_us) return true;
    ++skew_refused_;
    if (tries + 1 == kSkewTries) break;
    V4l2Camera& older = skew_us() < 0 ? left_ : right_;
    if (auto released = older.release(); !released) {
      stop();
      return tl::make_unexpected(released.error());
    }
  }
  return false;
}

/// A camera that is out is stopped, with its partner; one that has only just been started gets its
/// time.
Result<void> V4l2Pair::grab(V4l2Camera& camera, HostTime deadline) {
  const auto grabbed = camera.grab(deadline, clock_);
  if (grabbed && *grabbed) return {};
  const bool starting =
      !seen_since_start_ && clock_() - started_at_ < std::int64_t{config_.start_timeout_ms} * 1000;
  if (grabbed && starting) return fail(camera.name() + ": no image yet since it was opened");
  stop();
  if (!grabbed) return tl::make_unexpected(grabbed.error());
  return fail(camera.name() + ": no image within " + std::to_string(config_.timeout_ms) + " ms");
}

Result<Frame> V4l2Pair::retrieve_pair() {
  if (auto checked = check_time(); !checked) return tl::make_unexpected(checked.error());
  auto left = left_.retrieve();
  if (!left) return tl::make_unexpected(left.error());
  auto right = right_.retrieve();
  if (!right) return tl::make_unexpected(right.error());
  Frame frame;
  frame.index = index_++;
  frame.utime = left_.grabbed_at() + utime_offset_us_;
  frame.left = *left;
  frame.right = *right;
  frame.exposure_us = left_.exposure_us();
  return frame;
}

Result<void> V4l2Pair::check_time() const {
  const std::int64_t age_us = clock_() - left_.grabbed_at();
  if (age_us > kMaxAge_us || age_us < -kMaxAge_us) {
    return fail(left_.name() + ": the driver's time of an image is " + ms_text(std::abs(age_us)) +
                (age_us > 0 ? " old" : " in the future"));
  }
  if (left_.grabbed_at() <= last_at_) {
    return fail(left_.name() + ": the driver's time of an image does not advance");
  }
  return {};
}

}  // namespace cairn::camera
