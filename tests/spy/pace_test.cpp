// SPDX-License-Identifier: Apache-2.0
#include "procs/spy/pace.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace cairn::spy {
namespace {

constexpr std::int64_t kMs = 1000;
constexpr std::int64_t kSecond = 1'000'000;

TEST(PaceMeter, NothingIsSaidBeforeTheSecondArrival) {
  PaceMeter meter(PaceWindow::kNewest);
  EXPECT_FALSE(meter.pace(0));
  meter.add(5 * kMs, 100);
  EXPECT_FALSE(meter.pace(6 * kMs));
  meter.add(6 * kMs, 100);
  EXPECT_TRUE(meter.pace(6 * kMs));
}

// Intervals 100, 100 and 200 ms of 1000 bytes each: mean 400/3, variance (2 (100/3)^2 +
// (200/3)^2) / 3 = 20000/9.
TEST(PaceMeter, AgreesWithHandWorkedIntervals) {
  for (const PaceWindow window : {PaceWindow::kNewest, PaceWindow::kWhole}) {
    PaceMeter meter(window);
    for (const std::int64_t time_ms : {0, 100, 200, 400}) meter.add(time_ms * kMs, 1000);
    const Pace pace = meter.pace(400 * kMs).value();
    EXPECT_EQ(pace.intervals, 3);
    EXPECT_DOUBLE_EQ(pace.rate_hz, 7.5);
    EXPECT_DOUBLE_EQ(pace.bytes_per_s, 7500);
    EXPECT_DOUBLE_EQ(pace.min_interval_us, 100e3);
    EXPECT_DOUBLE_EQ(pace.max_interval_us, 200e3);
    EXPECT_NEAR(pace.mean_interval_us, 400e3 / 3, 1e-6);
    EXPECT_NEAR(pace.std_interval_us, std::sqrt(20000.0 / 9) * 1e3, 1e-6);
  }
}

TEST(PaceMeter, SilenceBeyondTheLongestIntervalLowersTheRate) {
  PaceMeter meter(PaceWindow::kNewest);
  for (const std::int64_t time_ms : {0, 100, 200, 400}) meter.add(time_ms * kMs, 1000);
  EXPECT_DOUBLE_EQ(meter.pace(600 * kMs)->rate_hz, 7.5);
  EXPECT_DOUBLE_EQ(meter.pace(1600 * kMs)->rate_hz, 3 / 1.4);
  EXPECT_DOUBLE_EQ(meter.pace(100 * kSecond)->rate_hz, 3 / 99.8);
}

TEST(PaceMeter, AFastChannelIsJudgedByItsNewestTwoSeconds) {
  PaceMeter newest(PaceWindow::kNewest);
  PaceMeter whole(PaceWindow::kWhole);
  const auto add = [&](std::int64_t time_us) {
    newest.add(time_us, 10);
    whole.add(time_us, 10);
  };
  std::int64_t now_us = 0;
  for (int i = 0; i <= 1000; ++i) add(now_us = i * 10 * kMs);
  for (int i = 0; i < 60; ++i) add(now_us += 50 * kMs);
  EXPECT_DOUBLE_EQ(newest.pace(now_us)->rate_hz, 20);
  EXPECT_EQ(newest.pace(now_us)->intervals, 40);
  EXPECT_DOUBLE_EQ(newest.pace(now_us)->std_interval_us, 0);
  EXPECT_DOUBLE_EQ(whole.pace(now_us)->rate_hz, 1060 / 13.0);
}

TEST(PaceMeter, ASlowChannelIsJudgedByItsNewestTenIntervals) {
  PaceMeter meter(PaceWindow::kNewest);
  std::int64_t now_us = 0;
  for (int i = 0; i < 5; ++i) meter.add(now_us += kSecond, 10);
  for (int i = 0; i < 10; ++i) meter.add(now_us += 30 * kSecond, 10);
  EXPECT_EQ(meter.pace(now_us)->intervals, 10);
  EXPECT_DOUBLE_EQ(meter.pace(now_us)->rate_hz, 1.0 / 30);
  EXPECT_DOUBLE_EQ(meter.pace(now_us + 29 * kSecond)->rate_hz, 1.0 / 30);
}

TEST(PaceMeter, WhatCameAllAtOnceHasNoPace) {
  PaceMeter meter(PaceWindow::kNewest);
  for (int i = 0; i < 3; ++i) meter.add(kSecond, 100);
  EXPECT_FALSE(meter.pace(kSecond));
  EXPECT_FALSE(meter.pace(2 * kSecond));
  meter.add(2 * kSecond, 100);
  EXPECT_DOUBLE_EQ(meter.pace(2 * kSecond)->rate_hz, 3);
}

TEST(PaceMeter, TimeThatGoesBackMakesNoInterval) {
  PaceMeter meter(PaceWindow::kWhole);
  for (const std::int64_t time_ms : {1000, 1100, 0, 100, 200}) meter.add(time_ms * kMs, 10);
  const Pace pace = meter.pace(200 * kMs).value();
  EXPECT_EQ(pace.intervals, 3);
  EXPECT_DOUBLE_EQ(pace.rate_hz, 10);
  EXPECT_DOUBLE_EQ(pace.max_interval_us, 100e3);
}

TEST(PaceMeter, SurvivesAnyTimes) {
  constexpr unsigned kSeed = 5;
  SCOPED_TRACE(kSeed);
  std::mt19937_64 random(kSeed);
  for (const PaceWindow window : {PaceWindow::kNewest, PaceWindow::kWhole}) {
    PaceMeter meter(window);
    meter.add(std::numeric_limits<std::int64_t>::min(), 1);
    meter.add(std::numeric_limits<std::int64_t>::max(), 1);
    for (int i = 0; i < 2000; ++i) {
      meter.add(static_cast<std::int64_t>(random()), 1);
      const auto pace = meter.pace(static_cast<std::int64_t>(random()));
      ASSERT_TRUE(pace);
      ASSERT_GE(pace->rate_hz, 0);
      ASSERT_GE(pace->min_interval_us, 0);
    }
  }
}

}  // namespace
}  // namespace cairn::spy
