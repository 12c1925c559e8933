// SPDX-License-Identifier: Apache-2.0
#include "procs/guard/guard_node.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "messages/disparity_messages.hpp"
#include "messages/geometry_messages.hpp"
#include "node_bench.hpp"
#include "stereo/depth_to_disparity.hpp"

namespace cairn {
namespace {

namespace channels = bus::channels;

constexpr std::int64_t kTick_us = 10'000;
constexpr std::int64_t kWheels_us = 20'000;
constexpr std::int64_t kFrame_us = 70'000;
constexpr double kTicksPerM = 5000;

/// A free level floor, seen by the level cameras of the simulated robot.
stereo::DisparityImage free_floor(Utime utime) {
  stereo::RectifiedCamera camera;
  camera.f_px = 554;
  camera.cx_px = 319.5;
  camera.cy_px = 239.5;
  camera.baseline_m = 0.254;
  camera.width_px = 640;
  camera.height_px = 480;
  camera.T_body_camera.linear() = R_body_camera_forward();
  camera.T_body_camera.translation() = Eigen::Vector3d(0, 0.127, 0.30);
  cv::Mat_<float> depth_m(480, 640, 0.0F);
  for (int row = 241; row < 480; ++row) {
    const double depth = 0.30 * camera.f_px / (row - camera.cy_px);
    if (depth > 0.75) depth_m.row(row).setTo(depth);
  }
  return stereo::disparity_from_depth(depth_m, camera, 2, utime).value();
}

/// guard on a bus with somebody who plays clock, stereo, motor and listens.
class GuardNodeTest : public testing::NodeBench {
 protected:
  GuardNodeTest() {
    peer_.on<channels::Clearance>([this](const clearance_t& heard) { heard_.push_back(heard); });
    clock_.set(now_);
    start_guard();
  }

  void start_guard() {
    guard_.reset();
    start_node("guard");
    guard_ = std::move(GuardNode::create({}, *node_).value());
  }

  /// Data time and host time go on by `seconds`; what is switched on is sent at its rate.
  void run(double seconds) {
    for (const Utime until = now_ + static_cast<Utime>(1e6 * seconds); now_ < until;) {
      now_ += kTick_us;
      clock_.set(now_);
      send_clock(now_);
      if (wheels_on_ && now_ % kWheels_us == 0) send_wheels();
      if (eyes_on_ && now_ % kFrame_us == 0)
        peer_.publish<channels::Disparity>(messages::to_message(free_floor(now_), 1).value(), now_);
      spin();
      way_m_ += speed_mps_ * to_seconds(kTick_us);
    }
  }

  void send_wheels() {
    wheel_state_t wheels{};
    wheels.left_ticks = wheels.right_ticks =
        ticks_from_ + static_cast<std::int64_t>(kTicksPerM * way_m_);
    wheels.ticks_per_m = kTicksPerM;
    wheels.left_measured_mps = wheels.right_measured_mps = speed_mps_;
    wheels.gate = wheel_state_t::GATE_DRIVING;
    peer_.publish<channels::WheelState>(wheels, now_);
  }

  /// Drives over free floor until guard allows full speed.
  void drive_until_free() {
    speed_mps_ = 0.4;
    run(3);
    ASSERT_EQ(heard_.back().max_forward_mps, 0.5) << heard_.back().reason;
  }

  std::unique_ptr<GuardNode> guard_;
  std::vector<clearance_t> heard_;
  Utime now_ = 1'000'000;
  double way_m_ = 0;
  double speed_mps_ = 0;
  std::int64_t ticks_from_ = 0;
  bool wheels_on_ = true;
  bool eyes_on_ = true;
};

TEST_F(GuardNodeTest, SpeaksTwentyTimesASecondFromTheStartAndAllowsNothing) {
  wheels_on_ = eyes_on_ = false;
  run(1);
  EXPECT_EQ(heard_.size(), 20U);
  for (const clearance_t& heard : heard_) EXPECT_EQ(heard.max_forward_mps, 0);
  EXPECT_EQ(heard_.back().reason, "no WHEEL_STATE yet");
}

TEST_F(GuardNodeTest, AllowsCreepingAtStartAndFullSpeedOnFloorItHasSeen) {
  run(0.5);
  EXPECT_EQ(heard_.back().max_forward_mps, 0.1) << heard_.back().reason;
  drive_until_free();
  EXPECT_GT(heard_.back().disparity_utime, now_ - 2 * kFrame_us);
}

TEST_F(GuardNodeTest, WithoutDisparityItAllowsNothingAfter400Milliseconds) {
  drive_until_free();
  eyes_on_ = false;
  run(0.55);
  EXPECT_EQ(heard_.back().max_forward_mps, 0);
  EXPECT_EQ(heard_.back().reason.rfind("no DISPARITY for", 0), 0U) << heard_.back().reason;
}

TEST_F(GuardNodeTest, WithoutWheelStateItAllowsNothing) {
  drive_until_free();
  wheels_on_ = false;
  run(0.35);
  EXPECT_EQ(heard_.back().max_forward_mps, 0);
  EXPECT_EQ(heard_.back().reason.rfind("no WHEEL_STATE for", 0), 0U) << heard_.back().reason;
}

TEST_F(GuardNodeTest, AWheelControllerThatStartsAnewMakesItForget) {
  drive_until_free();
  ticks_from_ -= 50'000;
  speed_mps_ = 0;
  run(0.5);
  EXPECT_LE(heard_.back().max_forward_mps, 0.1) << heard_.back().reason;
}

TEST_F(GuardNodeTest, RestartedItAllowsNothingUntilItHasSeenAgain) {
  drive_until_free();
  start_guard();
  speed_mps_ = 0;
  eyes_on_ = false;
  const std::size_t before = heard_.size();
  run(0.2);
  ASSERT_GT(heard_.size(), before);
  for (std::size_t i = before; i < heard_.size(); ++i) EXPECT_EQ(heard_[i].max_forward_mps, 0);
  eyes_on_ = true;
  run(0.3);
  EXPECT_EQ(heard_.back().max_forward_mps, 0.1) << heard_.back().reason;
}

TEST_F(GuardNodeTest, ARangeReadingShortensTheWay) {
  drive_until_free();
  range_t laser{};
  laser.kind = range_t::KIND_LASER;
  Isometry T_body_sensor = Isometry::Identity();
  T_body_sensor.translation() = Eigen::Vector3d(0.18, 0, 0.1);
  laser.T_body_sensor = messages::to_message(T_body_sensor);
  laser.range_m = 0.12;
  laser.min_range_m = 0.02;
  laser.max_range_m = 4;
  peer_.publish<channels::Range>(laser, now_);
  speed_mps_ = 0;
  run(0.05);
  EXPECT_LT(heard_.back().max_forward_mps, 0.1);
  EXPECT_EQ(heard_.back().reason.rfind("obstacle at", 0), 0U) << heard_.back().reason;
}

TEST_F(GuardNodeTest, BadMessagesAreRefusedCountedAndHarmless) {
  drive_until_free();
  wheel_state_t wheels{};
  wheels.ticks_per_m = 0;
  peer_.publish<channels::WheelState>(wheels, now_);
  range_t range{};
  range.kind = range_t::KIND_LASER;
  range.range_m = std::numeric_limits<double>::quiet_NaN();
  peer_.publish<channels::Range>(range, now_);
  disparity_t disparity{};
  disparity.columns = -1;
  peer_.publish<channels::Disparity>(disparity, now_ + 1);
  run(0.1);
  EXPECT_EQ(node_->counts().find(channels::WheelState::name)->second.refused, 1);
  EXPECT_EQ(node_->counts().find(channels::Range::name)->second.refused, 1);
  EXPECT_EQ(node_->counts().find(channels::Disparity::name)->second.refused, 1);
  EXPECT_EQ(heard_.back().max_forward_mps, 0.5) << heard_.back().reason;
}

// An image is placed by the wheel states up to 40 ms before it, however late they or it arrive.
TEST_F(GuardNodeTest, AnImageWaitsForItsWheelStates) {
  run(0.3);
  const auto last_seen = [this] { return heard_.back().disparity_utime; };
  eyes_on_ = false;
  wheels_on_ = false;
  run(0.05);
  const Utime before = last_seen();
  const Utime image = now_ + kFrame_us;
  peer_.publish<channels::Disparity>(messages::to_message(free_floor(image), 1).value(), image);
  run(0.05);
  EXPECT_EQ(last_seen(), before);
  now_ = image - 40'000;
  send_wheels();
  now_ = image;
  run(0.05);
  EXPECT_EQ(last_seen(), image);
}

}  // namespace
}  // namespace cairn
