// SPDX-License-Identifier: Apache-2.0
#include "motor/motor_control.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

#include "motor/memory_link.hpp"
#include "wheel_rig.hpp"

namespace cairn::motor {
namespace {

constexpr std::int64_t kMs = 1000;
constexpr HostTime kStart_us = 50'000'000;
constexpr Utime kData_us = 3'000'000'000;

/// A motor process without a bus, the reference controller at the end of its line, two tracks, and
/// those who tell it what to do; a clock that goes on by a millisecond at a time.
class MotorControlTest : public ::testing::Test {
 protected:
  MotorControlTest() { plug_in(1); }

  void plug_in(std::uint32_t session) {
    auto [far, near] = make_memory_links([this] { return now_us_; });
    waiting_ = std::move(near);
    rig_.emplace(std::move(far), session, now_us_);
  }

  Utime data_now() const { return kData_us + (now_us_ - kStart_us); }
  SentStamp stamp(std::int64_t session) { return {now_us_, session, ++sequence_}; }

  /// Who sends is well for `duration_us`: 10 Hz of orders, 20 Hz of permission and CLOCK.
  void pass(std::int64_t duration_us) {
    for (const HostTime until_us = now_us_ + duration_us; now_us_ < until_us;) {
      now_us_ += kMs;
      const std::int64_t since_us = now_us_ - kStart_us;
      if (clock_ && since_us % (50 * kMs) == 0) control_.clock(data_now(), 1, now_us_, now_us_);
      if (guard_ && since_us % (50 * kMs) == 7 * kMs) {
        ASSERT_TRUE(control_.gate().permit({stamp(2), 0.5, data_now() - 60 * kMs}, now_us_));
      }
      if (planner_ && since_us % (100 * kMs) == 13 * kMs) {
        ASSERT_TRUE(
            control_.gate().drive({stamp(1), Driver::kPlanner, 0, forward_, turn_}, now_us_));
      }
      if (rig_) rig_->run(now_us_);
      if (motor_ && since_us % MotorControl::kTick_us == 0) {
        const auto came = control_.tick(now_us_);
        readings_.insert(readings_.end(), came.begin(), came.end());
      }
    }
  }

  /// How long until the controller's drive is zero.
  std::int64_t until_zero_us() {
    const HostTime from_us = now_us_;
    while (rig_->driven() && now_us_ - from_us < kMicrosecondsPerSecond) pass(kMs);
    return now_us_ - from_us;
  }

  void drive_at(double forward, double turn = 0) {
    forward_ = forward;
    turn_ = turn;
    pass(1500 * kMs);
    ASSERT_NEAR(rig_->left.speed_mps, forward - turn * 0.13, 0.01);
    ASSERT_NEAR(rig_->right.speed_mps, forward + turn * 0.13, 0.01);
  }

  HostTime now_us_ = kStart_us;
  std::int32_t sequence_ = 0;
  std::unique_ptr<ByteLink> waiting_;
  std::optional<testing::WheelRig> rig_;
  bool clock_ = true;
  bool guard_ = true;
  bool planner_ = true;
  bool motor_ = true;
  double forward_ = 0.3;
  double turn_ = 0;
  std::vector<WheelReading> readings_;
  MotorControl control_{{},
                        {},
                        WheelLine("the line",
                                  [this]() -> Result<std::unique_ptr<ByteLink>> {
                                    if (waiting_ == nullptr) return fail("the line: not there");
                                    return std::move(waiting_);
                                  }),
                        false,
                        kStart_us};
};

TEST_F(MotorControlTest, StartsIdleAndSendsZero) {
  planner_ = false;
  pass(1000 * kMs);
  EXPECT_FALSE(rig_->driven());
  EXPECT_EQ(control_.hold(), Hold::kNobody);
  EXPECT_TRUE(control_.line().connected());
  ASSERT_FALSE(readings_.empty());
  EXPECT_EQ(readings_.back().gate, GateState::kIdle);
  EXPECT_EQ(readings_.back().faults, 0);
  EXPECT_EQ(rig_->controller().refused(), 0);
  EXPECT_EQ(rig_->controller().line().damaged, 0);
}

TEST_F(MotorControlTest, DrivesAsItIsTold) {
  drive_at(0.3);
  drive_at(-0.2);
  drive_at(0.2, 0.6);
  drive_at(0, -1);
  EXPECT_EQ(readings_.back().gate, GateState::kDriving);
  EXPECT_NEAR(readings_.back().left_commanded_mps, 0.13, 1e-9);
  EXPECT_NEAR(readings_.back().right_commanded_mps, -0.13, 1e-9);
  EXPECT_NEAR(readings_.back().left_measured_mps, 0.13, 0.01);
}

TEST_F(MotorControlTest, ATrackThatStandsAndIsToStandGetsNoDrive) {
  drive_at(0.3);
  forward_ = 0;
  pass(2000 * kMs);
  EXPECT_FALSE(rig_->driven());
  EXPECT_EQ(rig_->left.speed_mps, rig_->right.speed_mps);
  EXPECT_EQ(readings_.back().gate, GateState::kDriving);
}

TEST_F(MotorControlTest, ReadingsCome50TimesASecondWithEvenStampsThatAreTrue) {
  pass(500 * kMs);
  readings_.clear();
  pass(2000 * kMs);
  ASSERT_EQ(readings_.size(), 100u);
  for (std::size_t i = 1; i < readings_.size(); ++i)
    EXPECT_EQ(readings_[i].utime - readings_[i - 1].utime, 20 * kMs);
  // Read at the latest one tick after it was written.
  const Utime written = data_now();
  EXPECT_LE(readings_.back().utime, written);
  EXPECT_GT(readings_.back().utime, written - 20 * kMs - MotorControl::kTick_us);
}

TEST_F(MotorControlTest, HazardM14_TheDriveIsZeroSoonAfterPlannerGuardOrClockFallSilent) {
  std::int64_t worst_us[3] = {};
  for (int phase = 0; phase < 100; ++phase) {
    for (int who = 0; who < 3; ++who) {
      clock_ = guard_ = planner_ = true;
      forward_ = 0.3;
      turn_ = phase % 2 == 0 ? 0 : 0.4;
      pass(700 * kMs + phase * kMs);
      ASSERT_TRUE(rig_->driven());
      (who == 0 ? planner_ : who == 1 ? guard_ : clock_) = false;
      worst_us[who] = std::max(worst_us[who], until_zero_us());
      pass(500 * kMs);
      ASSERT_FALSE(rig_->driven());
    }
  }
  std::printf("zero after at most %.0f ms (planner), %.0f ms (guard), %.0f ms (clock)\n",
              1e-3 * static_cast<double>(worst_us[0]), 1e-3 * static_cast<double>(worst_us[1]),
              1e-3 * static_cast<double>(worst_us[2]));
  // 250 or 200 ms, one tick, and a millisecond of this test's clock for each way.
  EXPECT_LE(worst_us[0], 257 * kMs);
  EXPECT_LE(worst_us[1], 207 * kMs);
  EXPECT_LE(worst_us[2], 257 * kMs);
}

TEST_F(MotorControlTest, HazardM15_AMotorThatFreezesMovesNothingOver200Ms) {
  std::int64_t worst_us = 0;
  for (int phase = 0; phase < 50; ++phase) {
    motor_ = true;
    pass(700 * kMs + phase * kMs);
    ASSERT_TRUE(rig_->driven());
    motor_ = false;
    worst_us = std::max(worst_us, until_zero_us());
    pass(2000 * kMs);
  }
  std::printf("zero after at most %.0f ms\n", 1e-3 * static_cast<double>(worst_us));
  EXPECT_LE(worst_us, 201 * kMs);
}

TEST_F(MotorControlTest, HazardM16_StopIsOnTheLineBeforeItReturns) {
  drive_at(0.5);
  control_.stop(now_us_);
  pass(kMs);
  EXPECT_FALSE(rig_->driven());
  pass(3000 * kMs);
  EXPECT_FALSE(rig_->driven());
  EXPECT_EQ(readings_.back().gate, GateState::kLatched);
  EXPECT_EQ(control_.hold(), Hold::kLatched);
  ASSERT_TRUE(control_.gate().release(true, stamp(3), now_us_));
  const auto from = readings_.size();
  pass(12 * kMs);
  EXPECT_FALSE(rig_->driven()) << "a release revives nothing";
  pass(1000 * kMs);
  EXPECT_TRUE(rig_->driven()) << "a fresh order after it counts";
  EXPECT_EQ(readings_.at(from).gate, GateState::kIdle);
}

TEST_F(MotorControlTest, HazardM13_AfterALineWasLostOnlyAFreshOrderMoves) {
  for (int round = 0; round < 10; ++round) {
    pass(700 * kMs);
    ASSERT_TRUE(rig_->driven());
    rig_.reset();
    pass(10 * kMs);
    EXPECT_EQ(control_.hold(), Hold::kNoController);
    pass(20 * kMs);
    EXPECT_EQ(readings_.back().faults, kFaultNoController);
    EXPECT_EQ(readings_.back().gate, GateState::kIdle);
    EXPECT_EQ(readings_.back().left_commanded_mps, 0);
    pass(round * 77 * kMs);
    // The order comes at 13 ms past each tenth of a second; the line just after that.
    pass(100 * kMs - (now_us_ - kStart_us) % (100 * kMs) + 20 * kMs);
    planner_ = false;
    plug_in(static_cast<std::uint32_t>(100 + round));
    pass(1200 * kMs);
    ASSERT_TRUE(control_.line().connected());
    EXPECT_FALSE(rig_->driven());
    planner_ = true;
  }
}

TEST_F(MotorControlTest, AControllerThatStartsAnewWaitsForAFreshOrder) {
  pass(700 * kMs);
  ASSERT_TRUE(rig_->driven());
  // It resets, and nothing is lost on the line.
  planner_ = false;
  rig_->controller() = simulation::WheelController(99);
  pass(200 * kMs);
  EXPECT_FALSE(rig_->driven());
  planner_ = true;
  pass(300 * kMs);
  EXPECT_TRUE(rig_->driven());
}

TEST_F(MotorControlTest, ASilentControllerIsSaidWithin200Ms) {
  pass(700 * kMs);
  rig_->silent = true;
  pass(180 * kMs);
  EXPECT_EQ(readings_.back().faults & kFaultNoController, kFaultNoController);
  EXPECT_FALSE(rig_->driven());
}

TEST_F(MotorControlTest, WithoutAControllerReadingsSaySoAt50HzAndWhetherItIsLatched) {
  rig_.reset();
  waiting_.reset();
  pass(500 * kMs);
  readings_.clear();
  control_.stop(now_us_);
  pass(1000 * kMs);
  EXPECT_EQ(readings_.size(), 50u);
  for (const WheelReading& reading : readings_) {
    EXPECT_EQ(reading.faults, kFaultNoController);
    EXPECT_EQ(reading.gate, GateState::kLatched);
  }
}

TEST_F(MotorControlTest, AStuckTrackIsSaidAndGivenARest) {
  drive_at(0.3);
  rig_->left.blocked = true;
  bool seen = false;
  HostTime seen_us = 0;
  const HostTime from_us = now_us_;
  for (int i = 0; i < 300 && !seen; ++i) {
    pass(10 * kMs);
    seen = (readings_.back().faults & kFaultStalledLeft) != 0;
    seen_us = now_us_;
  }
  ASSERT_TRUE(seen);
  EXPECT_LE(seen_us - from_us, 1200 * kMs);
  EXPECT_EQ(readings_.back().faults & kFaultStalledRight, 0);
  EXPECT_EQ(control_.hold(), Hold::kStalled);
  pass(MotorControl::kRest_us - 100 * kMs);
  EXPECT_FALSE(rig_->driven());
  EXPECT_NE(readings_.back().faults & kFaultStalledLeft, 0);
  rig_->left.blocked = false;
  pass(2000 * kMs);
  EXPECT_NEAR(rig_->left.speed_mps, 0.3, 0.01);
  EXPECT_EQ(readings_.back().faults, 0);
}

TEST_F(MotorControlTest, ALowBatteryIsSaid) {
  rig_->controller().set_low_battery(true);
  pass(100 * kMs);
  EXPECT_EQ(readings_.back().faults, kFaultLowBattery);
}

TEST_F(MotorControlTest, WhatTheControllerIsToldNeverExceedsTheRobotsLimit) {
  forward_ = 0.5;
  turn_ = 1;
  pass(3000 * kMs);
  EXPECT_NEAR(rig_->right.speed_mps, 0.5, 0.01);
  EXPECT_NEAR(rig_->left.speed_mps, 0.5 - 2 * 0.13, 0.01);
  for (const WheelReading& reading : readings_)
    ASSERT_LE(std::abs(reading.right_commanded_mps), 0.5 + 1e-12);
}

}  // namespace
}  // namespace cairn::motor
