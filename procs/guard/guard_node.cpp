// SPDX-License-Identifier: Apache-2.0
#include "procs/guard/guard_node.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

#include "messages/check.hpp"
#include "messages/disparity_messages.hpp"
#include "messages/geometry_messages.hpp"

namespace cairn {

namespace channels = bus::channels;

namespace {

constexpr std::int64_t kPeriod_us = 50'000;
constexpr std::size_t kMaxWaiting = 8;
constexpr std::int32_t kFaultNoController = 1;

std::string silence(const char* channel, std::int64_t age_us) {
  char text[64];
  std::snprintf(text, sizeof text, "no %s for %.1f s", channel, to_seconds(age_us));
  return text;
}

}  // namespace

Result<std::unique_ptr<GuardNode>> GuardNode::create(const Config& config, bus::Node& node) {
  return std::make_unique<GuardNode>(config, node);
}

GuardNode::GuardNode(const Config& config, bus::Node& node)
    : config_{config},
      node_{node},
      tracks_{config.robot, config.tracks},
      clearance_{config.clearance, config.robot} {
  node.on<channels::Disparity>([this](const disparity_t& seen) { take(seen); });
  node.on<channels::WheelState>([this](const wheel_state_t& wheels) { take(wheels); });
  node.on<channels::Range>([this](const range_t& range) { take(range); });
  node.every_host(kPeriod_us, [this] {
    look_at_what_is_ready();
    publish();
  });
}

void GuardNode::take(const disparity_t& seen) {
  auto image = messages::to_disparity(seen);
  if (!image) return node_.refuse(channels::Disparity::name, image.error().message);
  if (image->utime < seen_utime_ - kMicrosecondsPerSecond) {
    seen_utime_ = 0;
    waiting_.clear();
    clearance_.forget();
  }
  if (image->utime <= seen_utime_) return;
  waiting_.push_back(std::move(*image));
  if (waiting_.size() > kMaxWaiting) waiting_.pop_front();
  look_at_what_is_ready();
}

void GuardNode::take(const wheel_state_t& wheels) {
  if (auto good = messages::check(wheels); !good)
    return node_.refuse(channels::WheelState::name, good.error().message);
  if ((wheels.faults & kFaultNoController) != 0) return;
  tracks_.add({wheels.header.utime, wheels.left_ticks, wheels.right_ticks, wheels.ticks_per_m,
               wheels.left_measured_mps, wheels.right_measured_mps});
  commanded_turn_radps_ =
      (wheels.right_commanded_mps - wheels.left_commanded_mps) / tracks_.gauge_m();
  look_at_what_is_ready();
}

void GuardNode::take(const range_t& range) {
  if (auto good = messages::check(range); !good)
    return node_.refuse(channels::Range::name, good.error().message);
  if (range.range_m >= range.max_range_m) return;
  const auto T_body_sensor = messages::to_isometry(range.T_body_sensor, "T_body_sensor");
  if (!T_body_sensor) return node_.refuse(channels::Range::name, T_body_sensor.error().message);
  auto moment = tracks_.at(range.header.utime);
  if (!moment) return;
  stand_on(*moment);
  const double range_m = std::max(range.range_m, range.min_range_m);
  const Eigen::Vector3d beam = T_body_sensor->linear().col(0);
  const double height_m = T_body_sensor->translation().z() + range_m * beam.z();
  const planning::GroundConfig& ground = config_.clearance.ground;
  if (height_m < ground.step_m || height_m > config_.robot.height_m + ground.headroom_m) return;
  planning::RangeReading reading;
  reading.utime = range.header.utime;
  reading.T_body_sensor.linear() =
      Eigen::Rotation2Dd(std::atan2(beam.y(), beam.x())).toRotationMatrix();
  reading.T_body_sensor.translation() = T_body_sensor->translation().head<2>();
  reading.range_m = range_m * beam.head<2>().norm();
  reading.half_angle_rad = range.half_angle_rad;
  clearance_.measure(reading, moment->T_start_body);
}

void GuardNode::look_at_what_is_ready() {
  while (!waiting_.empty() && tracks_.ready_for(waiting_.front().utime, node_.data_time())) {
    look_at(waiting_.front());
    waiting_.pop_front();
  }
}

// What was seen from where the tracks' chain does not lead cannot be told from here.
void GuardNode::stand_on(const odometry::TrackHistory::Moment& moment) {
  if (moment.chain == chain_) return;
  clearance_.forget();
  chain_ = moment.chain;
}

void GuardNode::look_at(const stereo::DisparityImage& image) {
  const auto moment = tracks_.at(image.utime);
  if (!moment) {
    ++node_.counter("seen_without_wheels");
    return;
  }
  stand_on(*moment);
  clearance_.see(image, moment->T_start_body);
  seen_utime_ = image.utime;
}

planning::Permission GuardNode::permission() const {
  const Utime now = node_.data_time();
  const auto newest = tracks_.newest();
  if (!newest) return {0, "no WHEEL_STATE yet"};
  const std::int64_t wheels_us = now - newest->reading.utime;
  if (std::abs(to_seconds(wheels_us)) > config_.max_wheel_age_s)
    return {0, silence("WHEEL_STATE", wheels_us)};
  if (seen_utime_ == 0) return {0, "no DISPARITY yet"};
  const std::int64_t sight_us = now - seen_utime_;
  if (std::abs(to_seconds(sight_us)) > config_.max_sight_age_s)
    return {0, silence("DISPARITY", sight_us)};
  if (newest->chain != chain_) return {0, "wheel controller started anew"};
  const double measured_turn_radps =
      (newest->reading.right_mps - newest->reading.left_mps) / tracks_.gauge_m();
  const auto by_measured = clearance_.judge(now, newest->T_start_body, measured_turn_radps);
  if (by_measured.max_forward_mps <= 0) return by_measured;
  const auto by_commanded = clearance_.judge(now, newest->T_start_body, commanded_turn_radps_);
  return by_commanded.max_forward_mps < by_measured.max_forward_mps ? by_commanded : by_measured;
}

void GuardNode::publish() {
  const planning::Permission allowed = permission();
  clearance_t message{};
  message.max_forward_mps = allowed.max_forward_mps;
  message.reason = allowed.reason;
  message.disparity_utime = seen_utime_;
  node_.publish<channels::Clearance>(std::move(message), node_.data_time());
}

}  // namespace cairn
