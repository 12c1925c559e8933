// SPDX-License-Identifier: Apache-2.0
#include "procs/odometry/odometry_node.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <random>
#include <vector>

#include "messages/calibration_messages.hpp"
#include "messages/check.hpp"
#include "node_bench.hpp"
#include "odometry/made_tracks.hpp"
#include "temporary_folder.hpp"

namespace cairn {
namespace {

namespace channels = bus::channels;
using testing::MadeTracks;
using testing::steady_tracks;

constexpr std::int64_t kTick_us = 10'000;
constexpr std::int64_t kWheels_us = 20'000;
constexpr std::int64_t kFrame_us = 70'000;
constexpr double kSpeed_mps = 0.3;
constexpr double kTurn_radps = 0.2;

OdometryConfig blind() {
  OdometryConfig config;
  config.visual = false;
  return config;
}

stereo_frame_t dark_frame(int width_px = 8, int height_px = 8) {
  stereo_frame_t frame{};
  frame.encoding = stereo_frame_t::ENCODING_RAW;
  frame.width_px = width_px;
  frame.height_px = height_px;
  frame.left_size = frame.right_size = width_px * height_px;
  frame.left.assign(static_cast<std::size_t>(frame.left_size), 0);
  frame.right = frame.left;
  return frame;
}

wheel_state_t to_message(const odometry::TrackReading& reading) {
  wheel_state_t wheels{};
  wheels.left_ticks = reading.left_ticks;
  wheels.right_ticks = reading.right_ticks;
  wheels.ticks_per_m = reading.ticks_per_m;
  wheels.left_measured_mps = reading.left_mps;
  wheels.right_measured_mps = reading.right_mps;
  wheels.gate = wheel_state_t::GATE_DRIVING;
  return wheels;
}

/// odometry on a bus with somebody who plays clock, camera, motor and listens.
class OdometryNodeTest : public testing::NodeBench {
 protected:
  OdometryNodeTest() {
    peer_.on<channels::Odometry>([this](const odometry_t& heard) {
      EXPECT_TRUE(messages::check(heard)) << messages::check(heard).error().message;
      heard_.push_back(heard);
    });
    clock_.set(now_);
  }

  void start(const OdometryConfig& config = blind(), StateFolder state = {}) {
    odometry_.reset();
    start_node("odometry", std::move(state));
    odometry_ = OdometryNode::create(config, *node_).value();
  }

  void send_wheels(Utime utime) {
    peer_.publish<channels::WheelState>(to_message(tracks_.reading(utime)), utime);
  }
  void send_frame(Utime utime) { peer_.publish<channels::StereoFrame>(dark_frame(), utime); }

  /// Data time and host time go on by `seconds`; what is switched on is sent at its rate.
  void run(double seconds) {
    for (const Utime until = now_ + static_cast<Utime>(1e6 * seconds); now_ < until;) {
      now_ += kTick_us;
      clock_.set(now_);
      send_clock(now_);
      if (wheels_on_ && now_ % kWheels_us == 0) send_wheels(now_);
      if (eyes_on_ && now_ % kFrame_us == 0) {
        send_frame(now_);
        ++sent_;
      }
      spin();
    }
  }

  /// How far the body went between two times, by the tracks.
  static double way_m(Utime from, Utime to) { return kSpeed_mps * to_seconds(to - from); }

  static Eigen::Vector3d place_m(const odometry_t& heard) {
    return Eigen::Map<const Eigen::Vector3d>(std::begin(heard.T_odom_body.position_m));
  }

  double length_m(std::size_t from, std::size_t to) const {
    double sum_m = 0;
    for (std::size_t i = from + 1; i <= to; ++i) {
      sum_m += (place_m(heard_[i]) - place_m(heard_[i - 1])).norm();
    }
    return sum_m;
  }

  std::unique_ptr<OdometryNode> odometry_;
  std::vector<odometry_t> heard_;
  MadeTracks tracks_{steady_tracks(kSpeed_mps, kTurn_radps)};
  Utime now_ = 1'000'000;
  std::size_t sent_ = 0;
  bool wheels_on_ = true;
  bool eyes_on_ = true;
};

TEST_F(OdometryNodeTest, ReckonsByTheTracksWhereItIsToldNotToLook) {
  start();
  eyes_on_ = false;
  run(0.1);
  eyes_on_ = true;
  run(3);
  ASSERT_EQ(heard_.size(), sent_);
  EXPECT_NEAR(length_m(0, heard_.size() - 1),
              way_m(heard_.front().header.utime, heard_.back().header.utime), 0.002);
  EXPECT_GT(heard_.back().quality, 0);
  EXPECT_LE(heard_.back().quality, 0.3);
  EXPECT_EQ(node_->counter("coasting"), 0);
  EXPECT_EQ(node_->counter("wheels_late"), 0);
}

TEST_F(OdometryNodeTest, InTheDarkTheTracksCarryOnAsWell) {
  OdometryConfig config;
  start(config);
  const auto rig = messages::as_sent(
      camera::rectified_rig(140, 140, 79.5, 59.5, 0.25, 160, 120, Isometry::Identity()));
  peer_.publish<channels::Calibration>(messages::to_message(rig, now_), now_);
  eyes_on_ = false;
  for (int i = 0; i < 20; ++i) {
    run(0.07);
    auto frame = dark_frame(160, 120);
    frame.calibration_id = static_cast<std::int64_t>(rig.id);
    peer_.publish<channels::StereoFrame>(frame, now_);
    spin();
  }
  ASSERT_EQ(heard_.size(), 20U);
  EXPECT_NEAR(length_m(0, 19), way_m(heard_.front().header.utime, heard_.back().header.utime),
              0.002);
}

TEST_F(OdometryNodeTest, WithoutAMotorEveryFrameIsAnsweredAtOnce) {
  start();
  wheels_on_ = false;
  for (int i = 0; i < 20; ++i) {
    run(0.07);
    EXPECT_EQ(heard_.size(), sent_);
  }
  EXPECT_EQ(heard_.back().quality, 0);
}

TEST_F(OdometryNodeTest, AFrameWaitsForTheWheelStatesUpTo40MillisecondsBeforeIt) {
  start();
  run(0.3);
  eyes_on_ = wheels_on_ = false;
  const Utime last_wheels = now_ - now_ % kWheels_us;
  const Utime frame = last_wheels + 100'000;
  now_ = frame;
  send_frame(frame);
  spin();
  const std::size_t before = heard_.size();
  for (Utime utime = last_wheels + kWheels_us; utime < frame - 40'000; utime += kWheels_us) {
    send_wheels(utime);
    spin();
    EXPECT_EQ(heard_.size(), before);
  }
  send_wheels(frame - 40'000);
  spin();
  ASSERT_EQ(heard_.size(), before + 1);
  EXPECT_EQ(heard_.back().header.utime, frame);
  EXPECT_EQ(node_->counter("wheels_late"), 0);
}

TEST_F(OdometryNodeTest, AMotorThatFallsSilentHoldsNoFrameBackForLongerThan200Milliseconds) {
  start();
  run(0.5);
  const Utime last_wheels = now_ - now_ % kWheels_us;
  wheels_on_ = false;
  for (int i = 0; i < 40; ++i) {
    run(0.05);
    const bool silent = now_ > last_wheels + odometry::TrackHistory::kSilence_us + kWheels_us;
    if (silent) {
      EXPECT_EQ(heard_.size(), sent_);
    }
  }
  EXPECT_GT(node_->counter("coasting"), 0);
  wheels_on_ = true;
  run(0.5);
  EXPECT_EQ(heard_.size(), sent_);
  EXPECT_NEAR((place_m(heard_.back()) - place_m(heard_.front())).norm(),
              way_m(heard_.front().header.utime, heard_.back().header.utime), 0.05)
      << "ticks bridge the silence";
}

TEST_F(OdometryNodeTest, ClockAloneReleasesAFrameThatWaits) {
  start();
  run(0.5);
  wheels_on_ = eyes_on_ = false;
  now_ += 60'000;
  send_frame(now_);
  spin();
  const std::size_t before = heard_.size();
  run(0.1);
  EXPECT_EQ(heard_.size(), before);
  run(0.1);
  EXPECT_EQ(heard_.size(), before + 1);
}

/// What odometry says when the same messages arrive in an order of their own: each is late by up to
/// 30 ms.
std::vector<odometry_t> say_in_the_order_of(unsigned seed) {
  struct Sent {
    Utime arrives;
    Utime utime;
    bool is_frame;
  };
  std::mt19937 random(seed);
  std::vector<Sent> all;
  for (Utime utime = 1'000'000; utime < 3'000'000; utime += kTick_us) {
    const Utime late = seed == 0 ? 0 : static_cast<Utime>(random() % 30'000);
    if (utime % kWheels_us == 0) all.push_back({utime + late / 2, utime, false});
    if (utime % kFrame_us == 0) all.push_back({utime + late, utime, true});
  }
  std::stable_sort(all.begin(), all.end(),
                   [](const Sent& a, const Sent& b) { return a.arrives < b.arrives; });
  bus::ManualClock clock;
  bus::InProcessHub hub;
  bus::Bus& peer_bus = hub.make_endpoint();
  bus::Node peer{"peer", peer_bus, clock, StateFolder{}, 1000};
  bus::Bus& own_bus = hub.make_endpoint();
  bus::Node node{"odometry", own_bus, clock, StateFolder{}, 1};
  const auto odometry = OdometryNode::create(blind(), node).value();
  std::vector<odometry_t> said;
  peer.on<channels::Odometry>([&](const odometry_t& heard) { said.push_back(heard); });
  const MadeTracks tracks{steady_tracks(kSpeed_mps, kTurn_radps)};
  for (const Sent& sent : all) {
    clock.set(sent.arrives);
    if (sent.is_frame) {
      peer.publish<channels::StereoFrame>(dark_frame(), sent.utime);
    } else {
      peer.publish<channels::WheelState>(to_message(tracks.reading(sent.utime)), sent.utime);
    }
    hub.deliver();
    do {
      node.spin_once(0);
    } while (node.has_work());
    hub.deliver();
    do {
      peer.spin_once(0);
    } while (peer.has_work());
  }
  EXPECT_EQ(node.counter("wheels_late"), 0);
  return said;
}

TEST(OdometryNodeJoin, TheOrderOfArrivalDoesNotMatter) {
  const auto expected = say_in_the_order_of(0);
  ASSERT_GT(expected.size(), 20U);
  for (unsigned seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(seed);
    const auto said = say_in_the_order_of(seed);
    // The last frames may still wait for theirs.
    ASSERT_GE(said.size() + 2, expected.size());
    for (std::size_t i = 0; i < said.size(); ++i) {
      EXPECT_EQ(said[i].header.utime, expected[i].header.utime);
      for (int k = 0; k < 3; ++k) {
        EXPECT_EQ(said[i].T_odom_body.position_m[k], expected[i].T_odom_body.position_m[k]);
        EXPECT_EQ(said[i].twist.linear_mps[k], expected[i].twist.linear_mps[k]);
      }
      EXPECT_TRUE(std::equal(std::begin(said[i].covariance), std::end(said[i].covariance),
                             std::begin(expected[i].covariance)));
    }
  }
}

TEST_F(OdometryNodeTest, AControllerThatStartsAnewMakesNoJump) {
  start();
  run(1);
  const double before_m = length_m(0, heard_.size() - 1);
  const auto way = steady_tracks(kSpeed_mps, kTurn_radps);
  const Utime anew = now_;
  tracks_ = MadeTracks{[=](double seconds) {
    const auto since = way(seconds - to_seconds(anew));
    return odometry::TrackWay{since.left_m - 4, since.right_m - 4};
  }};
  run(1);
  EXPECT_EQ(node_->counter("wheels_began_anew"), 2);
  EXPECT_EQ(heard_.size(), sent_);
  EXPECT_NEAR(length_m(0, heard_.size() - 1), before_m + kSpeed_mps * 1, 0.05);
}

TEST_F(OdometryNodeTest, WhatTheMotorSaysWithoutAControllerDoesNotCount) {
  start();
  run(0.5);
  wheels_on_ = false;
  for (int i = 0; i < 10; ++i) {
    auto wheels = to_message(tracks_.reading(now_ + kWheels_us));
    wheels.faults = 1;
    wheels.left_ticks = wheels.right_ticks = 0;
    peer_.publish<channels::WheelState>(wheels, now_ + kWheels_us);
    run(0.02);
  }
  EXPECT_EQ(node_->counter("wheels_without_controller"), 10);
  EXPECT_EQ(node_->counter("wheels_began_anew"), 1);
}

TEST_F(OdometryNodeTest, LateAndReorderedWheelStatesAreCountedAndChangeNothing) {
  start();
  run(0.5);
  const double before_m = length_m(0, heard_.size() - 1);
  send_wheels(now_ - 300'000);
  spin();
  EXPECT_EQ(node_->counter("wheels_late"), 1);
  EXPECT_EQ(node_->counter("wheels_out_of_order"), 1);
  run(0.5);
  EXPECT_EQ(heard_.size(), sent_);
  EXPECT_NEAR(length_m(0, heard_.size() - 1), before_m + kSpeed_mps * 0.5, 0.01);
}

TEST_F(OdometryNodeTest, WildWheelStatesNeitherBlockNorPoison) {
  start();
  constexpr unsigned kSeed = 23;
  std::mt19937_64 random(kSeed);
  const double wild[] = {std::nan(""), HUGE_VAL, -HUGE_VAL, 1e300, -3, 0};
  for (int i = 0; i < 600; ++i) {
    auto wheels = to_message(tracks_.reading(now_));
    Utime utime = now_;
    switch (random() % 6) {
      case 0:
        wheels.left_ticks = static_cast<std::int64_t>(random());
        break;
      case 1:
        wheels.right_measured_mps = wild[random() % std::size(wild)];
        break;
      case 2:
        wheels.ticks_per_m = wild[random() % std::size(wild)];
        break;
      case 3:
        utime = static_cast<Utime>(random() >> (1 + random() % 62));
        break;
      case 4:
        wheels.gate = static_cast<std::int8_t>(random());
        break;
      default:
        break;
    }
    peer_.publish<channels::WheelState>(wheels, utime);
    run(0.02);
  }
  wheels_on_ = true;
  run(2);
  EXPECT_EQ(heard_.size(), sent_) << kSeed;
  EXPECT_GT(node_->counts().find(channels::WheelState::name)->second.refused, 0);
  const auto last = heard_.size() - 1;
  EXPECT_NEAR(length_m(last - 10, last),
              way_m(heard_[last - 10].header.utime, heard_[last].header.utime), 0.005);
}

TEST_F(OdometryNodeTest, DeadEncodersSayThatItStandsAndThatIsAllThereIsToGoBy) {
  start();
  tracks_ = MadeTracks{[](double) { return odometry::TrackWay{}; }};
  run(2);
  EXPECT_EQ(heard_.size(), sent_);
  EXPECT_EQ(length_m(0, heard_.size() - 1), 0);
}

TEST_F(OdometryNodeTest, RestartedItGoesOnByTheTicksInANewEpoch) {
  const testing::TemporaryFolder folder;
  start(blind(), StateFolder::open(folder.path()).value());
  run(2);
  const odometry_t before = heard_.back();
  odometry_.reset();
  node_.reset();
  const Utime killed = now_;
  now_ += 1'000'000;
  start(blind(), StateFolder::open(folder.path()).value());
  heard_.clear();
  sent_ = 0;
  run(1);
  ASSERT_EQ(heard_.size(), sent_);
  EXPECT_EQ(heard_.front().epoch, before.epoch + 1);
  EXPECT_EQ(node_->counter("coasting"), 0);
  const double way = way_m(before.header.utime, heard_.front().header.utime);
  EXPECT_NEAR((place_m(heard_.front()) - place_m(before)).norm(), way, 0.02 * way) << killed;
}

TEST_F(OdometryNodeTest, AFrameThatIsNoFrameIsRefusedAndDoesNotHoldUpTheNext) {
  start();
  run(0.3);
  auto bad = dark_frame();
  bad.left_size = bad.right_size = 3;
  bad.left.resize(3);
  bad.right.resize(3);
  peer_.publish<channels::StereoFrame>(bad, now_ + 1);
  run(0.3);
  EXPECT_EQ(heard_.size(), sent_);
  EXPECT_EQ(node_->counts().find(channels::StereoFrame::name)->second.refused, 1);
}

}  // namespace
}  // namespace cairn
