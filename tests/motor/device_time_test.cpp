// SPDX-License-Identifier: Apache-2.0
#include "motor/device_time.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <random>
#include <vector>

namespace cairn::motor {
namespace {

constexpr std::int64_t kMs = 1000;
constexpr std::int64_t kPeriod_us = 20 * kMs;

/// The data time at which everything here starts: host time, and the controller's clock.
constexpr Utime kStart_us = 1'700'000'000'000'000;

TEST(DeviceTime, IsZeroBeforeTheFirstClock) {
  DeviceTime time;
  EXPECT_EQ(time.data_now(1000), 0);
  EXPECT_EQ(time.stamp(5, 1000), 0);
}

TEST(DeviceTime, GoesOnAtTheRateOfClockAndNotForLong) {
  DeviceTime time;
  time.tick(kStart_us, 4, 1000);
  EXPECT_EQ(time.data_now(1000), kStart_us);
  EXPECT_EQ(time.data_now(11'000), kStart_us + 40'000);
  EXPECT_EQ(time.data_now(90'000'000), kStart_us + 4 * DeviceTime::kMaxExtension_us);
  EXPECT_EQ(time.data_now(0), kStart_us);
}

/// Plays `seconds`, with readings that are late by what `late` says, and CLOCKs by `clock_late`
/// (they say a time that was, not the one that is); gives the stamps' errors.
template <class Late, class ClockLate>
std::vector<std::int64_t> errors(double rate, int seconds, Late late, ClockLate clock_late) {
  DeviceTime time;
  std::vector<std::int64_t> errors;
  const auto data_at = [&](HostTime host_us) {
    return kStart_us + static_cast<Utime>(rate * static_cast<double>(host_us));
  };
  struct Arrival {
    HostTime at_us;
    std::int64_t device_us;
  };
  std::vector<Arrival> arrivals;
  for (std::int64_t device_us = kPeriod_us; static_cast<double>(device_us) < rate * seconds * 1e6;
       device_us += kPeriod_us) {
    const auto read_us = static_cast<HostTime>(static_cast<double>(device_us) / rate);
    arrivals.push_back(
        {std::max(read_us + late(), arrivals.empty() ? 0 : arrivals.back().at_us), device_us});
  }
  HostTime next_clock_us = 0;
  for (const Arrival& arrival : arrivals) {
    while (next_clock_us <= arrival.at_us) {
      time.tick(data_at(next_clock_us - clock_late()), rate, next_clock_us);
      next_clock_us += 45 * kMs;
    }
    errors.push_back(time.stamp(arrival.device_us, arrival.at_us) -
                     (kStart_us + arrival.device_us));
  }
  return errors;
}

TEST(DeviceTime, StampsAreTrueAndEvenWhereReadingsAreLateByChance) {
  std::mt19937 random(1);
  for (const double rate : {1.0, 4.0}) {
    // Of host time: none outruns the one before it.
    std::uniform_int_distribution<std::int64_t> up_to_a_period(
        0, static_cast<std::int64_t>(static_cast<double>(kPeriod_us) / rate));
    const auto off = errors(
        rate, 20, [&] { return up_to_a_period(random); }, [] { return 0; });
    for (std::size_t i = 250; i < off.size(); ++i) {
      EXPECT_GE(off[i], 0);
      EXPECT_LE(off[i], kPeriod_us / 4);
      EXPECT_LE(std::abs(off[i] - off[i - 1]), kMs);
    }
  }
}

TEST(DeviceTime, OneLateClockMovesNoStamp) {
  std::mt19937 random(2);
  std::uniform_int_distribution<std::int64_t> up_to_5_ms(0, 5 * kMs);
  int clocks = 0;
  const auto off = errors(
      1, 20, [&] { return up_to_5_ms(random); },
      [&] { return ++clocks % 100 == 0 ? 80 * kMs : 0; });
  for (std::size_t i = 250; i < off.size(); ++i)
    EXPECT_NEAR(static_cast<double>(off[i]), 500, 1000);
}

TEST(DeviceTime, IsTheEighthSmallestDifferenceOfTheWindowByBruteForce) {
  std::mt19937_64 random(20240229);
  std::uniform_int_distribution<std::int64_t> any(0, 200 * kMs);
  for (int run = 0; run < 20; ++run) {
    DeviceTime time;
    HostTime now_us = 1'000'000;
    std::int64_t device_us = 0;
    HostTime ticked_us = now_us;
    Utime ticked = kStart_us;
    time.tick(ticked, 1, ticked_us);
    std::vector<std::pair<std::int64_t, std::int64_t>> all;  // device time, difference
    Utime last = 0;
    for (int i = 0; i < 600; ++i) {
      now_us += any(random) / 8;
      device_us += 1 + any(random) / 8;
      if (random() % 3 == 0) {
        ticked_us = now_us - any(random) / 20;
        ticked += any(random) / 5;
        time.tick(ticked, 1, ticked_us);
      }
      if (all.empty() || now_us - ticked_us <= DeviceTime::kMaxExtension_us) {
        const std::int64_t since_us =
            std::min<std::int64_t>(now_us - ticked_us, DeviceTime::kMaxExtension_us);
        all.emplace_back(device_us, ticked + since_us - device_us);
      }
      std::vector<std::int64_t> window;
      for (const auto& [at_us, difference_us] : all) {
        if (at_us >= all.back().first - DeviceTime::kWindow_us) window.push_back(difference_us);
      }
      if (window.size() > DeviceTime::kMaxReadings)
        window.erase(window.begin(), window.end() - DeviceTime::kMaxReadings);
      std::sort(window.begin(), window.end());
      const Utime expected = std::max(last + 1, device_us + window[window.size() / 8]);
      last = time.stamp(device_us, now_us);
      ASSERT_EQ(last, expected) << run << " " << i;
    }
  }
}

TEST(DeviceTime, StampsRiseWhateverComes) {
  std::mt19937_64 random(4);
  DeviceTime time;
  Utime last = 0;
  Utime utime = kStart_us;
  for (int i = 0; i < 20'000; ++i) {
    utime += static_cast<Utime>(random() % 2'000'000);
    if (i % 3 == 0) time.tick(utime, 1 + static_cast<double>(random() % 8), i * 1000);
    if (random() % 100 == 0) time.restart();
    const Utime stamp =
        time.stamp(static_cast<std::int64_t>(random() % 1000) + i * 20'000, i * 1000);
    ASSERT_GT(stamp, last);
    last = stamp;
  }
}

TEST(DeviceTime, FollowsDataTimeThatIsSetBackAtOnce) {
  DeviceTime time;
  for (int i = 0; i < 100; ++i) {
    time.tick(kStart_us + i * kPeriod_us, 1, i * kPeriod_us);
    (void)time.stamp(i * kPeriod_us, i * kPeriod_us);
  }
  time.tick(1'000'000, 1, 100 * kPeriod_us);
  EXPECT_EQ(time.stamp(100 * kPeriod_us, 100 * kPeriod_us), 1'000'000);
}

TEST(DeviceTime, FollowsDataTimeThatJumpsAheadAtOnce) {
  DeviceTime time;
  for (int i = 0; i < 100; ++i) {
    time.tick(kStart_us + i * kPeriod_us, 1, i * kPeriod_us);
    (void)time.stamp(i * kPeriod_us, i * kPeriod_us);
  }
  time.tick(kStart_us + 60'000'000, 1, 100 * kPeriod_us);
  EXPECT_EQ(time.stamp(100 * kPeriod_us, 100 * kPeriod_us), kStart_us + 60'000'000);
}

TEST(DeviceTime, AControllerThatStartedAnewHasAClockOfItsOwn) {
  DeviceTime time;
  time.tick(kStart_us, 1, 0);
  (void)time.stamp(900'000'000, 0);
  time.restart();
  EXPECT_EQ(time.stamp(5, 30 * kMs), kStart_us + 30 * kMs);
}

TEST(DeviceTime, LearnsNothingWhileDataTimeStandsStill) {
  DeviceTime time;
  for (int i = 0; i < 100; ++i) {
    time.tick(kStart_us + i * kPeriod_us, 1, i * kPeriod_us);
    (void)time.stamp(i * kPeriod_us, i * kPeriod_us);
  }
  for (int i = 100; i < 1000; ++i)
    EXPECT_EQ(time.stamp(i * kPeriod_us, i * kPeriod_us), kStart_us + i * kPeriod_us);
}

}  // namespace
}  // namespace cairn::motor
