// SPDX-License-Identifier: Apache-2.0
#include "messages/check.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "messages/geometry_messages.hpp"

namespace cairn::messages {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

template <class Message>
std::string verdict(const Message& message) {
  const auto checked = check(message);
  return checked ? "good" : checked.error().message;
}

odometry_t odometry() {
  odometry_t message{};
  message.T_odom_body = to_message(Isometry::Identity());
  message.quality = 0.5;
  return message;
}

TEST(Check, Odometry) {
  EXPECT_EQ(verdict(odometry()), "good");
  auto bad = odometry();
  bad.header.utime = -1;
  EXPECT_EQ(verdict(bad), "ODOMETRY header.utime: is negative");
  bad = odometry();
  bad.T_odom_body.position_m[0] = kNan;
  EXPECT_EQ(verdict(bad), "ODOMETRY T_odom_body.position_m: not finite");
  bad = odometry();
  bad.twist.linear_mps[0] = kNan;
  EXPECT_EQ(verdict(bad), "ODOMETRY twist: not finite");
  bad = odometry();
  bad.covariance[0] = -1;
  EXPECT_EQ(verdict(bad), "ODOMETRY covariance: negative variance in row 0");
  bad = odometry();
  bad.quality = kNan;
  EXPECT_EQ(verdict(bad), "ODOMETRY quality: is nan, not within 0.000000 and 1.000000");
  bad = odometry();
  bad.epoch = -1;
  EXPECT_EQ(verdict(bad), "ODOMETRY epoch: is negative");
}

TEST(Check, Pose) {
  pose_t good{};
  good.T_map_body = to_message(Isometry::Identity());
  good.T_map_odom = good.T_map_body;
  EXPECT_EQ(verdict(good), "good");
  pose_t bad = good;
  bad.state = 3;
  EXPECT_EQ(verdict(bad), "POSE state: is 3, which means nothing");
  bad = good;
  bad.T_map_odom = isometry_t{};
  EXPECT_NE(verdict(bad).find("POSE T_map_odom.orientation_xyzw: norm"), std::string::npos);
}

TEST(Check, StereoFrame) {
  stereo_frame_t good{};
  good.width_px = 3;
  good.height_px = 2;
  good.left_size = good.right_size = 6;
  good.left.resize(6);
  good.right.resize(6);
  EXPECT_EQ(verdict(good), "good");
  auto bad = good;
  bad.right_size = 7;
  EXPECT_EQ(verdict(bad), "STEREO_FRAME left_size, right_size: are not those of the images");
  bad = good;
  bad.width_px = 5000;
  EXPECT_NE(verdict(bad).find("STEREO_FRAME width_px"), std::string::npos);
  bad = good;
  bad.height_px = 3;
  EXPECT_EQ(verdict(bad), "STEREO_FRAME left_size: is not width times height");
  bad = good;
  bad.encoding = stereo_frame_t::ENCODING_JPEG;
  EXPECT_NE(verdict(bad).find("STEREO_FRAME jpeg_quality"), std::string::npos);
  bad.encoding = 2;
  EXPECT_EQ(verdict(bad), "STEREO_FRAME encoding: is 2, which means nothing");
}

TEST(Check, WheelState) {
  wheel_state_t good{};
  good.ticks_per_m = 1000;
  EXPECT_EQ(verdict(good), "good");
  auto bad = good;
  bad.ticks_per_m = 0;
  EXPECT_EQ(verdict(bad), "WHEEL_STATE ticks_per_m: is not positive");
  bad = good;
  bad.right_measured_mps = kNan;
  EXPECT_EQ(verdict(bad), "WHEEL_STATE right_measured_mps: is not finite");
  bad = good;
  bad.gate = -1;
  EXPECT_EQ(verdict(bad), "WHEEL_STATE gate: is -1, which means nothing");
}

TEST(Check, DriveCommand) {
  drive_command_t good{};
  good.source = drive_command_t::SOURCE_PERSON;
  EXPECT_EQ(verdict(good), "good");
  auto bad = good;
  bad.source = 0;
  EXPECT_EQ(verdict(bad), "DRIVE_COMMAND source: is 0, which means nothing");
  bad = good;
  bad.turn_radps = -INFINITY;
  EXPECT_EQ(verdict(bad), "DRIVE_COMMAND turn_radps: is not finite");
}

TEST(Check, Range) {
  range_t good{};
  good.kind = range_t::KIND_LASER;
  good.T_body_sensor = to_message(Isometry::Identity());
  good.max_range_m = 4;
  EXPECT_EQ(verdict(good), "good");
  auto bad = good;
  bad.range_m = kNan;
  EXPECT_EQ(verdict(bad), "RANGE range_m: is not finite");
  bad = good;
  bad.min_range_m = 4;
  EXPECT_EQ(verdict(bad), "RANGE max_range_m: is not over min_range_m");
  bad = good;
  bad.half_angle_rad = 2;
  EXPECT_NE(verdict(bad).find("RANGE half_angle_rad"), std::string::npos);
}

TEST(Check, Goal) {
  goal_t good{};
  good.action = goal_t::ACTION_GO;
  EXPECT_EQ(verdict(good), "good");
  goal_t bad = good;
  bad.action = 4;
  EXPECT_EQ(verdict(bad), "GOAL action: is 4, which means nothing");
  bad = good;
  bad.x_m = 1e7;
  EXPECT_EQ(verdict(bad).rfind("GOAL x_m: is 10000000", 0), 0U);
  bad = good;
  bad.y_m = kNan;
  EXPECT_EQ(verdict(bad).rfind("GOAL y_m: is nan", 0), 0U);
  bad = good;
  bad.heading_rad = kNan;
  EXPECT_EQ(verdict(bad), "GOAL heading_rad: is not finite");
  bad.action = goal_t::ACTION_EXPLORE;
  EXPECT_EQ(verdict(bad), "good") << "only a place to go to has a heading";
}

TEST(Check, Clearance) {
  clearance_t good{};
  EXPECT_EQ(verdict(good), "good");
  auto bad = good;
  bad.max_forward_mps = -0.1;
  EXPECT_EQ(verdict(bad), "CLEARANCE max_forward_mps: is negative");
  bad.max_forward_mps = INFINITY;
  EXPECT_EQ(verdict(bad), "CLEARANCE max_forward_mps: is not finite");
}

TEST(Check, Clock) {
  cairn::clock_t good{};
  good.rate = 1000;
  EXPECT_EQ(verdict(good), "good");
  for (const double rate : {0.0, -1.0, 1000.1}) {
    cairn::clock_t bad{};
    bad.rate = rate;
    EXPECT_EQ(verdict(bad), "CLOCK rate: is not above 0 and at most 1000");
  }
}

}  // namespace
}  // namespace cairn::messages
