// SPDX-License-Identifier: Apache-2.0
// H-SUP-1: back-off, crash loops, hangs and orderly ends, on a clock that the test sets.
#include "procs/supervisor/process_life.hpp"

#include <gtest/gtest.h>

#include <csignal>
#include <random>

namespace cairn {
namespace {

using Action = ProcessLife::Action;
using State = ProcessLife::State;

constexpr std::int64_t kSecond = kMicrosecondsPerSecond;
constexpr std::int64_t kTick = 20'000;

/// One process, its life, and a clock that goes on in ticks.
struct Bench {
  HostTime now_us = 1'000 * kSecond;
  ProcessLife life{ProcessLife::Policy{}, ProcessLife::Memory{}};
  std::vector<HostTime> starts_us;

  /// Ticks until an action is due, at most for `longest_us`; carries out a start.
  Action until_action(std::int64_t longest_us) {
    const HostTime end_us = now_us + longest_us;
    for (; now_us <= end_us; now_us += kTick) {
      const Action action = life.next(now_us);
      if (action == Action::kNone) continue;
      if (action == Action::kStart) {
        life.started(now_us);
        starts_us.push_back(now_us);
      }
      return action;
    }
    return Action::kNone;
  }
  /// Ticks for so long with a heartbeat a second; no action may be due.
  void run_well(std::int64_t duration_us) {
    const HostTime end_us = now_us + duration_us;
    for (int tick = 0; now_us < end_us; now_us += kTick, ++tick) {
      if (tick % 50 == 0) life.heard(now_us, true, "");
      ASSERT_EQ(life.next(now_us), Action::kNone);
    }
  }
};

TEST(ProcessLife, IsStartedAtOnceAndRunsFromItsFirstHeartbeatOn) {
  Bench bench;
  EXPECT_EQ(bench.life.state(bench.now_us), State::kStopped);
  EXPECT_EQ(bench.until_action(0), Action::kStart);
  EXPECT_EQ(bench.life.state(bench.now_us), State::kStarting);
  EXPECT_FALSE(bench.life.ready());
  bench.life.heard(bench.now_us, false, "reads the map");
  EXPECT_EQ(bench.life.state(bench.now_us), State::kStarting)
      << "it says itself that it is not ready";
  EXPECT_EQ(bench.life.reason(bench.now_us), "reads the map");
  bench.life.heard(bench.now_us, true, "");
  EXPECT_EQ(bench.life.state(bench.now_us), State::kRunning);
  EXPECT_TRUE(bench.life.ready());
  EXPECT_EQ(bench.life.restarts(), 0);
}

TEST(ProcessLife, ADeathIsFollowedByAStartAfterAQuarterOfASecond) {
  Bench bench;
  ASSERT_EQ(bench.until_action(0), Action::kStart);
  bench.run_well(10 * kSecond);
  const HostTime death_us = bench.now_us;
  bench.life.ended(death_us, -SIGKILL);
  EXPECT_EQ(bench.life.state(death_us), State::kStopped);
  EXPECT_EQ(bench.life.exit_code(), -SIGKILL);
  EXPECT_EQ(bench.life.reason(death_us), "killed by SIGKILL; starts again in 0.3 s");
  ASSERT_EQ(bench.until_action(kSecond), Action::kStart);
  EXPECT_NEAR(static_cast<double>(bench.now_us - death_us), 250e3, kTick);
  EXPECT_EQ(bench.life.restarts(), 1);
}

TEST(ProcessLife, QuickDeathsDoubleTheDelayAndTheFifthWithinAMinuteIsTheLast) {
  Bench bench;
  std::vector<double> delays_s;
  HostTime death_us = bench.now_us;
  while (bench.until_action(100 * kSecond) == Action::kStart) {
    delays_s.push_back(to_seconds(bench.now_us - death_us));
    bench.now_us += kTick;
    death_us = bench.now_us;
    bench.life.ended(death_us, 1);
  }
  ASSERT_EQ(delays_s.size(), 5U);
  for (std::size_t i = 1; i < 5; ++i) EXPECT_NEAR(delays_s[i], 0.125 * std::pow(2, i), 0.03) << i;
  EXPECT_EQ(bench.life.state(bench.now_us), State::kFailed);
  EXPECT_EQ(bench.life.reason(bench.now_us),
            "given up after 5 quick deaths; the last: ended with code 1");
}

TEST(ProcessLife, OneThatIsNeverHeardIsKilledAndTriedAgainEver30SecondsLater) {
  Bench bench;
  std::vector<double> delays_s;
  HostTime death_us = bench.now_us;
  for (int i = 0; i < 12; ++i) {
    ASSERT_EQ(bench.until_action(100 * kSecond), Action::kStart);
    delays_s.push_back(to_seconds(bench.now_us - death_us));
    ASSERT_EQ(bench.until_action(31 * kSecond), Action::kKill);
    death_us = bench.now_us;
    EXPECT_EQ(bench.life.state(death_us), State::kHung);
    bench.life.ended(death_us, -SIGKILL);
  }
  for (std::size_t i = 1; i < delays_s.size(); ++i) {
    EXPECT_NEAR(delays_s[i], std::min(30.0, 0.125 * std::pow(2, i)), 0.03) << i;
  }
  EXPECT_NE(bench.life.state(bench.now_us), State::kFailed) << "5 within a minute do not fit";
}

TEST(ProcessLife, AMinuteOfHealthBeginsTheBackOffAnew) {
  Bench bench;
  for (int i = 0; i < 4; ++i) {
    ASSERT_EQ(bench.until_action(100 * kSecond), Action::kStart);
    bench.life.ended(bench.now_us += kTick, 1);
  }
  ASSERT_EQ(bench.until_action(100 * kSecond), Action::kStart);
  bench.run_well(61 * kSecond);
  for (int i = 0; i < 4; ++i) {
    bench.life.ended(bench.now_us, 1);
    const HostTime death_us = bench.now_us;
    ASSERT_EQ(bench.until_action(100 * kSecond), Action::kStart) << i;
    EXPECT_NEAR(to_seconds(bench.now_us - death_us), i == 0 ? 0.25 : 0.125 * std::pow(2, i), 0.03);
    bench.now_us += kTick;
  }
  EXPECT_NE(bench.life.state(bench.now_us), State::kFailed);
}

// However long it lives each time: the property of the house's hazard table.
TEST(ProcessLife, NeverStartsMoreThanTenTimesWithinAMinute) {
  for (unsigned seed = 1; seed <= 300; ++seed) {
    std::mt19937 random(seed);
    Bench bench;
    const double longest_s = std::uniform_real_distribution<>(0.02, 12)(random);
    const HostTime end_us = bench.now_us + 180 * kSecond;
    while (bench.now_us < end_us) {
      const Action action = bench.until_action(100 * kSecond);
      if (action == Action::kNone) break;
      ASSERT_EQ(action, Action::kStart);
      const double life_s = std::uniform_real_distribution<>(0, longest_s)(random);
      bench.run_well(static_cast<std::int64_t>(1e6 * life_s));
      bench.life.ended(bench.now_us, 1);
    }
    for (std::size_t i = 10; i < bench.starts_us.size(); ++i) {
      ASSERT_GE(bench.starts_us[i] - bench.starts_us[i - 10], 60 * kSecond) << "seed " << seed;
    }
  }
}

TEST(ProcessLife, OneThatWasGivenUpGetsAnotherChanceByHand) {
  Bench bench;
  while (bench.until_action(100 * kSecond) == Action::kStart) {
    bench.life.ended(bench.now_us += kTick, 1);
  }
  ASSERT_EQ(bench.life.state(bench.now_us), State::kFailed);
  bench.life.want(bench.now_us);
  EXPECT_EQ(bench.until_action(0), Action::kStart);
  EXPECT_EQ(bench.life.restarts(), 5);
}

TEST(ProcessLife, SilenceIsFlaggedAfter2SecondsAndEndedBefore3) {
  Bench bench;
  ASSERT_EQ(bench.until_action(0), Action::kStart);
  bench.life.heard(bench.now_us, true, "");
  const HostTime last_us = bench.now_us;
  EXPECT_EQ(bench.life.state(last_us + 1'999'999), State::kRunning);
  EXPECT_EQ(bench.life.state(last_us + 2'000'000), State::kHung);
  ASSERT_EQ(bench.until_action(10 * kSecond), Action::kKill);
  EXPECT_NEAR(to_seconds(bench.now_us - last_us), 2.75, 0.03);
  EXPECT_EQ(bench.until_action(kSecond), Action::kNone) << "once is enough";
  bench.life.ended(bench.now_us, -SIGKILL);
  EXPECT_EQ(bench.life.memory().reason, "killed, because it did not answer");
  EXPECT_EQ(bench.until_action(kSecond), Action::kStart);
}

TEST(ProcessLife, OneThatSpeaksAgainIsLeftAlone) {
  Bench bench;
  ASSERT_EQ(bench.until_action(0), Action::kStart);
  bench.life.heard(bench.now_us, true, "");
  ASSERT_EQ(bench.until_action(2'500'000), Action::kNone);
  EXPECT_EQ(bench.life.state(bench.now_us), State::kHung);
  bench.life.heard(bench.now_us, true, "");
  EXPECT_EQ(bench.life.state(bench.now_us), State::kRunning);
  EXPECT_EQ(bench.until_action(1'900'000), Action::kNone);
}

TEST(ProcessLife, WhatNobodyListenedToIsNoSilence) {
  Bench bench;
  ASSERT_EQ(bench.until_action(0), Action::kStart);
  bench.life.heard(bench.now_us, true, "");
  bench.now_us += 100 * kSecond;
  bench.life.nobody_listened(100 * kSecond);
  EXPECT_EQ(bench.life.state(bench.now_us), State::kRunning);
  EXPECT_EQ(bench.life.next(bench.now_us), Action::kNone);
}

TEST(ProcessLife, IsAskedTwiceBeforeItIsMadeToEnd) {
  Bench bench;
  ASSERT_EQ(bench.until_action(0), Action::kStart);
  bench.run_well(kSecond);
  const HostTime asked_us = bench.now_us;
  bench.life.want_not(asked_us);
  EXPECT_EQ(bench.until_action(20 * kSecond), Action::kInterrupt);
  EXPECT_EQ(bench.now_us, asked_us);
  EXPECT_EQ(bench.life.reason(bench.now_us), "is being ended");
  EXPECT_EQ(bench.until_action(20 * kSecond), Action::kTerminate);
  EXPECT_NEAR(to_seconds(bench.now_us - asked_us), 5, 0.03);
  EXPECT_EQ(bench.until_action(20 * kSecond), Action::kKill);
  EXPECT_NEAR(to_seconds(bench.now_us - asked_us), 10, 0.03);
  EXPECT_EQ(bench.until_action(20 * kSecond), Action::kNone);
  bench.life.ended(bench.now_us, -SIGKILL);
  EXPECT_EQ(bench.life.state(bench.now_us), State::kStopped);
  EXPECT_EQ(bench.life.reason(bench.now_us), "stopped by hand; it had to be killed");
  EXPECT_EQ(bench.until_action(100 * kSecond), Action::kNone);
}

TEST(ProcessLife, ARestartByHandKnowsNoBackOff) {
  Bench bench;
  ASSERT_EQ(bench.until_action(0), Action::kStart);
  for (int i = 0; i < 20; ++i) {
    bench.life.heard(bench.now_us, true, "");
    bench.life.restart(bench.now_us);
    ASSERT_EQ(bench.until_action(0), Action::kInterrupt);
    bench.life.ended(bench.now_us, 0);
    ASSERT_EQ(bench.until_action(0), Action::kStart) << i;
  }
  EXPECT_EQ(bench.life.restarts(), 20);
}

TEST(ProcessLife, WhatEndsWellByItselfIsDoneWhereItsPolicySaysSo) {
  for (const auto policy : {ProcessLife::Restart::kOnFailure, ProcessLife::Restart::kNever}) {
    Bench bench;
    bench.life = ProcessLife({policy, kSecond}, {});
    ASSERT_EQ(bench.until_action(0), Action::kStart);
    bench.run_well(kSecond);
    bench.life.ended(bench.now_us, 0);
    EXPECT_EQ(bench.life.state(bench.now_us), State::kStopped);
    EXPECT_FALSE(bench.life.wanted());
    EXPECT_EQ(bench.until_action(100 * kSecond), Action::kNone);
  }
}

TEST(ProcessLife, WhatEndsBadlyIsTriedAgainOrHasFailedByItsPolicy) {
  Bench bench;
  bench.life = ProcessLife({ProcessLife::Restart::kOnFailure, kSecond}, {});
  ASSERT_EQ(bench.until_action(0), Action::kStart);
  bench.life.ended(bench.now_us, std::nullopt);
  EXPECT_EQ(bench.until_action(kSecond), Action::kStart) << "nobody knows that it ended well";
  bench.life = ProcessLife({ProcessLife::Restart::kNever, kSecond}, {});
  ASSERT_EQ(bench.until_action(0), Action::kStart);
  bench.life.ended(bench.now_us, -SIGSEGV);
  EXPECT_EQ(bench.life.state(bench.now_us), State::kFailed);
  EXPECT_EQ(bench.life.reason(bench.now_us), "killed by SIGSEGV");
}

TEST(ProcessLife, ASupervisorThatTakesOverCountsOnAndKeepsWhatPeopleWanted) {
  Bench before;
  ASSERT_EQ(before.until_action(0), Action::kStart);
  before.run_well(10 * kSecond);
  before.life.ended(before.now_us, 1);
  ASSERT_EQ(before.until_action(kSecond), Action::kStart);
  Bench after;
  after.life = ProcessLife({}, before.life.memory());
  after.life.adopted(after.now_us);
  EXPECT_EQ(after.until_action(kSecond), Action::kNone);
  EXPECT_EQ(after.life.restarts(), 1);
  before.life.want_not(before.now_us);
  after.life = ProcessLife({}, before.life.memory());
  after.life.adopted(after.now_us);
  EXPECT_EQ(after.until_action(0), Action::kInterrupt) << "it was being ended";
}

TEST(ProcessLife, WhatCannotBeStartedIsAQuickDeath) {
  Bench bench;
  int tries = 0;
  for (HostTime end_us = bench.now_us + 60 * kSecond; bench.now_us < end_us;
       bench.now_us += kTick) {
    if (bench.life.next(bench.now_us) != Action::kStart) continue;
    ++tries;
    bench.life.could_not_start(bench.now_us, "cairn-nobody: cannot be run: No such file");
  }
  EXPECT_EQ(tries, 5);
  EXPECT_EQ(bench.life.reason(bench.now_us),
            "given up after 5 quick deaths; the last: cairn-nobody: cannot be run: No such file");
}

TEST(ProcessLife, EndsAreSaidInWords) {
  EXPECT_EQ(describe_end(3), "ended with code 3");
  EXPECT_EQ(describe_end(-SIGSEGV), "killed by SIGSEGV");
  EXPECT_EQ(describe_end(-100), "killed by signal 100");
  EXPECT_EQ(describe_end(std::nullopt), "ended");
}

}  // namespace
}  // namespace cairn
