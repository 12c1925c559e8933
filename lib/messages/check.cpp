// SPDX-License-Identifier: Apache-2.0
#include "messages/check.hpp"

#include <cmath>
#include <initializer_list>
#include <string>

#include "core/time.hpp"
#include "messages/geometry_messages.hpp"
#include "messages/image_messages.hpp"

namespace cairn::messages {
namespace {

constexpr double kMaxClockRate = 1000;
/// 36,000 years; beyond it sums of times may overflow.
constexpr Utime kMaxClockUtime_us = Utime{1} << 60;

/// Goes through one message field by field and keeps the first thing that is wrong.
class Checker {
 public:
  explicit Checker(std::string channel) : channel_(std::move(channel)) {}

  Checker& header(const header_t& header) {
    require(header.utime >= 0, "header.utime", "is negative");
    return require(header.sequence >= 0, "header.sequence", "is negative");
  }

  Checker& finite(const char* field, double value) {
    return require(std::isfinite(value), field, "is not finite");
  }

  Checker& within(const char* field, double value, double low, double high) {
    return require(value >= low && value <= high, field,
                   "is " + std::to_string(value) + ", not within " + std::to_string(low) + " and " +
                       std::to_string(high));
  }

  Checker& not_negative(const char* field, double value) {
    finite(field, value);
    return require(value >= 0, field, "is negative");
  }

  Checker& one_of(const char* field, int value, std::initializer_list<int> known) {
    bool found = false;
    for (const int code : known) found = found || code == value;
    return require(found, field, "is " + std::to_string(value) + ", which means nothing");
  }

  template <class T>
  Checker& holds(const Result<T>& result) {
    if (verdict_ && !result) verdict_ = fail(channel_ + " " + result.error().message);
    return *this;
  }

  Checker& require(bool good, const char* field, const std::string& what) {
    if (verdict_ && !good) verdict_ = fail(channel_ + " " + field + ": " + what);
    return *this;
  }

  [[nodiscard]] Result<void> verdict() const { return verdict_; }

 private:
  std::string channel_;
  Result<void> verdict_;
};

}  // namespace

Result<void> check(const odometry_t& message) {
  return Checker("ODOMETRY")
      .header(message.header)
      .holds(to_isometry(message.T_odom_body, "T_odom_body"))
      .holds(to_twist(message.twist, "twist"))
      .holds(to_covariance(message.covariance, "covariance"))
      .within("quality", message.quality, 0, 1)
      .require(message.epoch >= 0, "epoch", "is negative")
      .require(message.tracked >= 0, "tracked", "is negative")
      .require(message.inliers >= 0, "inliers", "is negative")
      .verdict();
}

Result<void> check(const pose_t& message) {
  return Checker("POSE")
      .header(message.header)
      .holds(to_isometry(message.T_map_body, "T_map_body"))
      .holds(to_isometry(message.T_map_odom, "T_map_odom"))
      .holds(to_covariance(message.covariance, "covariance"))
      .require(message.epoch >= 0, "epoch", "is negative")
      .one_of("state", message.state,
              {pose_t::STATE_LOST, pose_t::STATE_AMBIGUOUS, pose_t::STATE_TRACKING})
      .verdict();
}

Result<void> check(const stereo_frame_t& message) {
  Checker checker("STEREO_FRAME");
  checker.header(message.header)
      .require(message.counts_agree(), "left_size, right_size", "are not those of the images")
      .within("width_px", message.width_px, 1, kMaxImageSide_px)
      .within("height_px", message.height_px, 1, kMaxImageSide_px)
      .require(message.frame_index >= 0, "frame_index", "is negative")
      .require(message.exposure_us >= 0, "exposure_us", "is negative")
      .one_of("encoding", message.encoding,
              {stereo_frame_t::ENCODING_RAW, stereo_frame_t::ENCODING_JPEG});
  if (message.encoding == stereo_frame_t::ENCODING_JPEG) {
    return checker.within("jpeg_quality", message.jpeg_quality, 1, 100).verdict();
  }
  const std::int64_t pixels = std::int64_t{message.width_px} * message.height_px;
  return checker.require(message.left_size == pixels, "left_size", "is not width times height")
      .require(message.right_size == pixels, "right_size", "is not width times height")
      .verdict();
}

Result<void> check(const wheel_state_t& message) {
  return Checker("WHEEL_STATE")
      .header(message.header)
      .finite("ticks_per_m", message.ticks_per_m)
      .require(message.ticks_per_m > 0, "ticks_per_m", "is not positive")
      .finite("left_measured_mps", message.left_measured_mps)
      .finite("right_measured_mps", message.right_measured_mps)
      .finite("left_commanded_mps", message.left_commanded_mps)
      .finite("right_commanded_mps", message.right_commanded_mps)
      .one_of("gate", message.gate,
              {wheel_state_t::GATE_IDLE, wheel_state_t::GATE_DRIVING, wheel_state_t::GATE_LATCHED})
      .verdict();
}

Result<void> check(const drive_command_t& message) {
  return Checker("DRIVE_COMMAND")
      .header(message.header)
      .one_of("source", message.source,
              {drive_command_t::SOURCE_PLANNER, drive_command_t::SOURCE_PERSON})
      .finite("forward_mps", message.forward_mps)
      .finite("turn_radps", message.turn_radps)
      .verdict();
}

Result<void> check(const goal_t& message) {
  Checker checker("GOAL");
  checker.header(message.header)
      .one_of("action", message.action,
              {goal_t::ACTION_GO, goal_t::ACTION_CANCEL, goal_t::ACTION_EXPLORE});
  if (message.action != goal_t::ACTION_GO) return checker.verdict();
  return checker.within("x_m", message.x_m, -kMaxPosition_m, kMaxPosition_m)
      .within("y_m", message.y_m, -kMaxPosition_m, kMaxPosition_m)
      .finite("heading_rad", message.heading_rad)
      .verdict();
}

Result<void> check(const range_t& message) {
  return Checker("RANGE")
      .header(message.header)
      .one_of("kind", message.kind, {range_t::KIND_ULTRASONIC, range_t::KIND_LASER})
      .holds(to_isometry(message.T_body_sensor, "T_body_sensor"))
      .not_negative("range_m", message.range_m)
      .not_negative("min_range_m", message.min_range_m)
      .not_negative("max_range_m", message.max_range_m)
      .require(message.min_range_m < message.max_range_m, "max_range_m", "is not over min_range_m")
      .within("half_angle_rad", message.half_angle_rad, 0, M_PI_2)
      .verdict();
}

Result<void> check(const clearance_t& message) {
  return Checker("CLEARANCE")
      .header(message.header)
      .not_negative("max_forward_mps", message.max_forward_mps)
      .require(message.disparity_utime >= 0, "disparity_utime", "is negative")
      .verdict();
}

Result<void> check(const clock_t& message) {
  return Checker("CLOCK")
      .header(message.header)
      .require(message.header.utime <= kMaxClockUtime_us, "header.utime", "is no time")
      .finite("rate", message.rate)
      .require(message.rate > 0 && message.rate <= kMaxClockRate, "rate",
               "is not above 0 and at most 1000")
      .verdict();
}

Result<void> check(const stop_t& message) {
  return Checker("STOP")
      .header(message.header)
      .one_of("action", message.action, {stop_t::ACTION_STOP, stop_t::ACTION_RELEASE})
      .verdict();
}

}  // namespace cairn::messages
