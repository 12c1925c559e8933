// SPDX-License-Identifier: Apache-2.0
// The hazards, with the real motor program on a real bus and a pseudo-terminal.
#include "motor_group.hpp"

namespace cairn::testing {
namespace {

class MotorProcess : public MotorGroup {};

TEST_F(MotorProcess, HazardM20_WheelsGetZeroWithin300MsOfAnyFreezing) {
  start_all();
  for (const std::string who : {"planner", "guard", "clock", "motor"}) {
    Distribution times(who + " frozen");
    for (int trial = 0; trial < trial_count(); ++trial) {
      measure(times, [&] { signal(who, SIGSTOP); });
      if (HasFatalFailure()) return;
      EXPECT_FALSE(bench_->driven());
      signal(who, SIGCONT);
    }
    judge(times, 300);
  }
}

TEST_F(MotorProcess, HazardM21_WheelsGetZeroWithin300MsOfAnyDeath) {
  start_all();
  const std::map<std::string, std::function<void()>> start_again{
      {"planner",
       [this] {
         start_voice("planner", {"drive", "0.3", "0.1"});
       }},
      {"guard", [this] { start_voice("guard", {"clearance"}); }},
      {"clock", [this] { start_voice("clock", {"clock"}); }},
      {"motor", [this] { start_motor(); }}};
  for (const auto& [who, start_it] : start_again) {
    Distribution times(who + " killed");
    for (int trial = 0; trial < trial_count(); ++trial) {
      measure(times, [&, name = who] { signal(name, SIGKILL); });
      if (HasFatalFailure()) return;
      EXPECT_FALSE(bench_->driven());
      start_it();
    }
    judge(times, 300);
  }
}

TEST_F(MotorProcess, HazardM22_StopIsZeroWithin100Ms) {
  start_all();
  Distribution times("STOP");
  for (int trial = 0; trial < trial_count(); ++trial) {
    HostTime stopped_us = 0;
    measure(times, [&] {
      stopped_us = clock_.now_us();
      say(stop_t::ACTION_STOP);
    });
    if (HasFatalFailure()) return;
    EXPECT_TRUE(latched_since(stopped_us));
    say(stop_t::ACTION_RELEASE);
  }
  judge(times, 100);
}

TEST_F(MotorProcess, HazardM23_StopIsZeroWithin100MsWhileTheBusIsFlooded) {
  start_all();
  start_voice("flood", {"flood", "5000"});
  Distribution times("STOP, 5000 messages a second");
  for (int trial = 0; trial < trial_count(); ++trial) {
    HostTime stopped_us = 0;
    measure(times, [&] {
      stopped_us = clock_.now_us();
      say(stop_t::ACTION_STOP);
    });
    if (HasFatalFailure()) return;
    EXPECT_TRUE(latched_since(stopped_us));
    say(stop_t::ACTION_RELEASE);
  }
  judge(times, 100);
  EXPECT_TRUE(until([this] { return status_.pid != 0; }));
}

TEST_F(MotorProcess, HazardM24_WhatWasLatchedIsLatchedAfterAnyKillAndAReleaseRevivesNothing) {
  start_all();
  int acknowledged = 0;
  for (int trial = 0; trial < trial_count(); ++trial) {
    ASSERT_TRUE(until([this] { return moves(); })) << output("motor");
    const HostTime stopped_us = clock_.now_us();
    say(stop_t::ACTION_STOP);
    // From before STOP has arrived to long after it was acknowledged.
    listen_for(static_cast<std::int64_t>(random_() % 60'000));
    const bool was_acknowledged = latched_since(stopped_us);
    acknowledged += was_acknowledged ? 1 : 0;
    signal("motor", SIGKILL);
    start_motor();
    const HostTime restarted_us = clock_.now_us();
    ASSERT_TRUE(until([&] { return heard_us_ > restarted_us && wheels_->faults == 0; }));
    if (was_acknowledged) {
      EXPECT_EQ(wheels_->gate, wheel_state_t::GATE_LATCHED);
      listen_for(300 * kMs);
      EXPECT_FALSE(bench_->driven());
    }
    // The order that came last is fresh still when the release comes.
    signal("planner", SIGSTOP);
    ASSERT_TRUE(until([this] { return !bench_->driven(); }));
    say(stop_t::ACTION_STOP);
    ASSERT_TRUE(until([&, again_us = clock_.now_us()] { return latched_since(again_us); }));
    const HostTime latched_us = clock_.now_us();
    say(stop_t::ACTION_RELEASE);
    listen_for(300 * kMs);
    EXPECT_LT(bench_->last_driven_us(), latched_us + 15 * kMs);
    EXPECT_EQ(wheels_->gate, wheel_state_t::GATE_IDLE);
    signal("planner", SIGCONT);
  }
  EXPECT_GT(acknowledged, 0);
  std::printf("%d of %d were acknowledged before the kill\n", acknowledged, trial_count());
}

TEST_F(MotorProcess, HazardM25_SigtermSendsZeroBeforeItEnds) {
  start_all();
  Distribution times("SIGTERM");
  for (int trial = 0; trial < trial_count(); ++trial) {
    measure(times, [&] { signal("motor", SIGTERM); });
    if (HasFatalFailure()) return;
    ASSERT_TRUE(until([this] { return children_.at("motor").exit_code().has_value(); }));
    EXPECT_EQ(children_.at("motor").exit_code(), 0);
    start_motor();
  }
  judge(times, 150);
}

TEST_F(MotorProcess, HazardM19_WithoutADeviceItSaysSoAndDrivesOnceThereIsOneAndAFreshOrder) {
  start_voice("clock", {"clock"});
  start_voice("guard", {"clearance"});
  start_motor();
  ASSERT_TRUE(until([this] {
    return status_.reason ==
           "no wheel controller: " + device_.string() +
               ": no such device; is the wheel controller connected and on? `ls -l "
               "/dev/serial/by-id` lists serial ports";
  })) << status_.reason;
  EXPECT_EQ(status_.health, process_status_t::HEALTH_ILL);
  EXPECT_EQ(wheels_->faults, 1);
  start_voice("planner", {"drive", "0.3", "0.1"});
  bench_.emplace(device_);
  const HostTime there_us = clock_.now_us();
  EXPECT_TRUE(until([this] { return moves(); }));
  EXPECT_LE(clock_.now_us() - there_us, 4 * kMicrosecondsPerSecond);
}

}  // namespace
}  // namespace cairn::testing
