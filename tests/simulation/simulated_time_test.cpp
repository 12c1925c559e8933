// SPDX-License-Identifier: Apache-2.0
#include "procs/simulator/simulated_time.hpp"

#include <gtest/gtest.h>

namespace cairn {
namespace {

constexpr Utime kStart_us = kMicrosecondsPerSecond;
constexpr HostTime kHost_us = 5'000'000'000;

TEST(SimulatedTime, IsAsFastAsItIsTold) {
  for (const double speed : {0.5, 1.0, 8.0}) {
    SimulatedTime time(speed, kStart_us, kHost_us);
    Utime reached = kStart_us;
    for (HostTime host_us = 0; host_us <= 3'600'000'000; host_us += 100'000) {
      reached = time.due(reached, kHost_us + host_us);
      ASSERT_EQ(reached, kStart_us + static_cast<Utime>(speed * static_cast<double>(host_us)));
    }
    EXPECT_EQ(time.lost_us(), 0);
  }
}

TEST(SimulatedTime, MakesUpForAShortStallAndLosesWhatIsMore) {
  SimulatedTime time(2, kStart_us, kHost_us);
  const HostTime stall_us = SimulatedTime::kMakesUp_us;
  Utime reached = time.due(kStart_us, kHost_us + stall_us);
  EXPECT_EQ(reached, kStart_us + 2 * stall_us);
  reached = time.due(reached, kHost_us + stall_us + 1'000'000);
  EXPECT_EQ(reached, kStart_us + 4 * stall_us);
  EXPECT_EQ(time.lost_us(), 2 * (1'000'000 - stall_us));
  EXPECT_EQ(time.due(reached, kHost_us + stall_us + 1'001'000), reached + 2'000);
}

TEST(SimulatedTime, HeldItDoesNotCatchUp) {
  SimulatedTime time(4, kStart_us, kHost_us);
  time.hold(kStart_us + 70'000, kHost_us + 100'000);
  EXPECT_EQ(time.due(kStart_us + 70'000, kHost_us + 101'000), kStart_us + 74'000);
  EXPECT_EQ(time.lost_us(), 0);
}

}  // namespace
}  // namespace cairn
