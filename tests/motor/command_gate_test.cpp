// SPDX-License-Identifier: Apache-2.0
#include "motor/command_gate.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <vector>

namespace cairn::motor {
namespace {

constexpr HostTime kStart_us = 1'000'000'000;
constexpr Utime kData_us = 5'000'000;
constexpr std::int64_t kMs = 1000;
constexpr GateLimits kLimits{0.5, 1.0, 0.26};

/// A gate, the clock, and those who speak to it. Data time goes on with host time.
class CommandGateTest : public ::testing::Test {
 protected:
  HostTime now() const { return now_us_; }
  Utime data_now() const { return kData_us + (now_us_ - kStart_us); }
  void pass(std::int64_t duration_us) { now_us_ += duration_us; }

  SentStamp stamp(std::int64_t session, HostTime sent_us) {
    return {sent_us, session, ++sequence_};
  }
  Verdict planner(double forward, double turn = 0, std::int64_t age_us = 0) {
    return gate_.drive({stamp(1, now_us_ - age_us), Driver::kPlanner, 0, forward, turn}, now_us_);
  }
  Verdict person(std::int64_t lease, double forward, double turn = 0) {
    return gate_.drive({stamp(10 + lease, now_us_), Driver::kPerson, lease, forward, turn},
                       now_us_);
  }
  Verdict guard(double max_forward = 0.5, std::int64_t age_us = 0,
                std::int64_t sight_us = 50 * kMs) {
    return gate_.permit({stamp(2, now_us_ - age_us), max_forward, data_now() - sight_us}, now_us_);
  }
  void clock() { gate_.clock(data_now(), now_us_, now_us_); }
  /// One millisecond after the start, with a clock and a clear view.
  void all_well() {
    pass(kMs);
    clock();
    ASSERT_TRUE(guard());
  }
  GateOutput output() const { return gate_.output(now_us_, data_now()); }

  void expect_standing(Hold hold) const {
    EXPECT_TRUE(output().stands());
    EXPECT_EQ(output().forward_mps, 0);
    EXPECT_EQ(output().turn_radps, 0);
    EXPECT_EQ(output().hold, hold);
  }
  void expect_driving(double forward, double turn) const {
    EXPECT_EQ(output().state, GateState::kDriving);
    EXPECT_EQ(output().forward_mps, forward);
    EXPECT_EQ(output().turn_radps, turn);
  }
  static void expect_refused(const Verdict& verdict, const std::string& kind) {
    ASSERT_FALSE(verdict);
    EXPECT_EQ(verdict.error().kind, kind);
    EXPECT_NE(verdict.error().why, "");
  }

  HostTime now_us_ = kStart_us;
  std::int32_t sequence_ = 0;
  CommandGate gate_{kLimits, false, kStart_us};
};

TEST_F(CommandGateTest, StartsIdleAndMovesByAFreshOrder) {
  all_well();
  expect_standing(Hold::kNobody);
  ASSERT_TRUE(planner(0.3, 0.2));
  expect_driving(0.3, 0.2);
  EXPECT_EQ(output().hold, Hold::kNone);
}

TEST_F(CommandGateTest, NothingSentBeforeItsStartCounts) {
  pass(100 * kMs);
  clock();
  ASSERT_TRUE(guard());
  ASSERT_TRUE(planner(0.3, 0, 100 * kMs));
  expect_standing(Hold::kNobody);
}

TEST_F(CommandGateTest, HazardM01_AnOrderCountsFor250MsFromSending) {
  all_well();
  pass(150 * kMs);
  // It waited 150 ms in a queue: 100 ms are left.
  ASSERT_TRUE(planner(0.3, 0, 150 * kMs));
  pass(100 * kMs);
  clock();
  ASSERT_TRUE(guard());
  expect_driving(0.3, 0);
  pass(1);
  expect_standing(Hold::kSilent);
}

TEST_F(CommandGateTest, HazardM02_AnOrderOver250MsOldIsRefused) {
  all_well();
  pass(kMicrosecondsPerSecond);
  EXPECT_TRUE(planner(0.3, 0, CommandGate::kMaxCommandAge_us));
  expect_refused(planner(0.3, 0, CommandGate::kMaxCommandAge_us + 1), "stale");
}

TEST_F(CommandGateTest, HazardM02_AnOrderFromTheFutureIsRefused) {
  all_well();
  expect_refused(planner(0.3, 0, -1), "future");
  expect_refused(gate_.drive({{std::numeric_limits<HostTime>::max(), 1, 9}, {}, 0, 0.1, 0}, now()),
                 "future");
  expect_refused(gate_.drive({{std::numeric_limits<HostTime>::min(), 1, 9}, {}, 0, 0.1, 0}, now()),
                 "stale");
}

TEST_F(CommandGateTest, HazardM03_AReplayedOrOutrunOrderIsRefused) {
  all_well();
  const DriveOrder first{{now(), 1, 100}, Driver::kPlanner, 0, 0.3, 0};
  ASSERT_TRUE(gate_.drive(first, now()));
  expect_refused(gate_.drive(first, now()), "replayed");
  pass(10 * kMs);
  expect_refused(gate_.drive({{now(), 1, 99}, Driver::kPlanner, 0, 0.4, 0}, now()), "replayed");
  // Higher in sequence, and sent before.
  expect_refused(gate_.drive({{now() - 20 * kMs, 1, 101}, Driver::kPlanner, 0, 0.4, 0}, now()),
                 "replayed");
  EXPECT_EQ(output().forward_mps, 0.3);
}

TEST_F(CommandGateTest, HazardM03_ARestartedPlannerIsHeardAndItsFormerSelfIsNot) {
  all_well();
  ASSERT_TRUE(gate_.drive({{now(), 1, 5000}, Driver::kPlanner, 0, 0.3, 0}, now()));
  pass(100 * kMs);
  ASSERT_TRUE(gate_.drive({{now(), 77, 0}, Driver::kPlanner, 0, 0.2, 0}, now()));
  expect_refused(gate_.drive({{now() - 50 * kMs, 1, 5001}, Driver::kPlanner, 0, 0.4, 0}, now()),
                 "replayed");
  EXPECT_EQ(output().forward_mps, 0.2);
}

TEST_F(CommandGateTest, HazardM04_WhatIsNoNumberOrTooFastIsRefused) {
  all_well();
  const double nan = std::nan("");
  const double inf = std::numeric_limits<double>::infinity();
  for (const double bad : {nan, inf, -inf}) {
    expect_refused(planner(bad, 0), "not_finite");
    expect_refused(planner(0, bad), "not_finite");
  }
  expect_refused(planner(0.501, 0), "too_fast");
  expect_refused(planner(-0.501, 0), "too_fast");
  expect_refused(planner(0, 1.001), "too_fast");
  expect_refused(planner(1e300, 0), "too_fast");
  expect_standing(Hold::kNobody);
  EXPECT_TRUE(planner(0.5, 0));
  EXPECT_TRUE(planner(0.5 * (1 + 1e-9), 0)) << "a sender's rounding";
  EXPECT_LE(output().forward_mps, 0.5);
}

TEST_F(CommandGateTest, ARefusedOrderLeavesTheOneBeforeItInForceForItsTime) {
  all_well();
  ASSERT_TRUE(planner(0.3));
  expect_refused(planner(std::nan("")), "not_finite");
  expect_driving(0.3, 0);
}

TEST_F(CommandGateTest, HazardM05_NothingMovesWhileClockStandsStill) {
  all_well();
  pass(CommandGate::kMaxClockAge_us);
  ASSERT_TRUE(planner(0.3));
  ASSERT_TRUE(guard());
  expect_driving(0.3, 0);
  pass(1);
  expect_standing(Hold::kNoClock);
  // The same time said again is no time that goes on.
  gate_.clock(kData_us + kMs, now(), now());
  expect_standing(Hold::kNoClock);
  clock();
  expect_driving(0.3, 0);
}

TEST_F(CommandGateTest, HazardM05_AClockThatWaitedInAQueueIsAsOldAsItsSending) {
  all_well();
  pass(kMicrosecondsPerSecond);
  ASSERT_TRUE(planner(0.3));
  ASSERT_TRUE(guard());
  gate_.clock(data_now(), now() - CommandGate::kMaxClockAge_us - 1, now());
  expect_standing(Hold::kNoClock);
}

TEST_F(CommandGateTest, NothingMovesBeforeTheFirstClock) {
  pass(kMs);
  ASSERT_TRUE(guard());
  ASSERT_TRUE(planner(0.3));
  expect_standing(Hold::kNoClock);
}

TEST_F(CommandGateTest, HazardM06_PermissionCountsFor200MsFromSending) {
  all_well();
  pass(120 * kMs);
  ASSERT_TRUE(guard(0.5, 120 * kMs, 0));
  pass(80 * kMs);
  clock();
  ASSERT_TRUE(planner(0.3));
  expect_driving(0.3, 0);
  pass(1);
  expect_standing(Hold::kNoGuard);
}

TEST_F(CommandGateTest, HazardM06_WithoutAGuardAPlannerDoesNothingAtAll) {
  all_well();
  pass(CommandGate::kMaxPermissionAge_us + 1);
  clock();
  for (const auto& [forward, turn] : {std::pair{0.3, 0.0}, {0.3, 0.4}, {0.0, 0.4}, {-0.2, 0.0}}) {
    ASSERT_TRUE(planner(forward, turn));
    expect_standing(Hold::kNoGuard);
  }
}

TEST_F(CommandGateTest, HazardM06_WithoutAGuardAPersonTurnsAndBacksButGoesNotForward) {
  all_well();
  pass(CommandGate::kMaxPermissionAge_us + 1);
  clock();
  ASSERT_TRUE(person(7, 0.3));
  expect_standing(Hold::kNoGuard);
  ASSERT_TRUE(person(7, 0.3, 0.4));
  expect_driving(0, 0.4);
  EXPECT_EQ(output().hold, Hold::kNoGuard);
  ASSERT_TRUE(person(7, -0.2, 0.4));
  expect_driving(-0.2, 0.4);
  EXPECT_EQ(output().hold, Hold::kNone);
}

TEST_F(CommandGateTest, HazardM07_PermissionThatRestsOnAnOldPictureIsNone) {
  all_well();
  pass(kMs);
  ASSERT_TRUE(guard(0.5, 0, CommandGate::kMaxDisparityAge_us));
  ASSERT_TRUE(planner(0.3));
  expect_driving(0.3, 0);
  ASSERT_TRUE(guard(0.5, 0, CommandGate::kMaxDisparityAge_us + 1));
  expect_standing(Hold::kNoSight);
  ASSERT_TRUE(planner(0.3, 0.4));
  expect_driving(0, 0.4);
  EXPECT_EQ(output().hold, Hold::kNoSight);
}

TEST_F(CommandGateTest, HazardM07_PermissionThatRestsOnAPictureFromTheFutureIsNone) {
  all_well();
  ASSERT_TRUE(guard(0.5, 0, -CommandGate::kMaxDisparityAge_us - 1));
  ASSERT_TRUE(planner(0.3));
  expect_standing(Hold::kNoSight);
}

TEST_F(CommandGateTest, ForwardIsNoFasterThanPermitted) {
  all_well();
  ASSERT_TRUE(guard(0.1));
  ASSERT_TRUE(planner(0.3, 0.2));
  expect_driving(0.1, 0.2);
  EXPECT_EQ(output().hold, Hold::kNone);
  pass(kMs);
  ASSERT_TRUE(guard(0));
  expect_driving(0, 0.2);
  EXPECT_EQ(output().hold, Hold::kNotFree);
  ASSERT_TRUE(planner(-0.3));
  expect_driving(-0.3, 0);
}

TEST_F(CommandGateTest, APermissionThatIsNoSpeedTakesAwayTheOneBefore) {
  all_well();
  ASSERT_TRUE(planner(0.3));
  expect_driving(0.3, 0);
  expect_refused(guard(std::nan("")), "not_finite");
  expect_standing(Hold::kNoGuard);
}

TEST_F(CommandGateTest, APermissionThatIsReplayedStaleOrNegativeMovesNothing) {
  all_well();
  ASSERT_TRUE(planner(0.3));
  pass(kMs);
  const ForwardPermission none{{now(), 2, 1000}, 0, data_now()};
  const ForwardPermission free{{now() - 500, 2, 999}, 0.5, data_now()};
  ASSERT_TRUE(gate_.permit(none, now()));
  expect_refused(gate_.permit(free, now()), "replayed");
  EXPECT_EQ(output().forward_mps, 0);
  sequence_ = 1000;
  ASSERT_TRUE(guard(-1));
  EXPECT_EQ(output().forward_mps, 0);
  pass(300 * kMs);
  expect_refused(guard(0.5, 300 * kMs), "stale");
}

TEST_F(CommandGateTest, HazardM08_StopLatchesUntilAPersonReleases) {
  all_well();
  ASSERT_TRUE(planner(0.3));
  gate_.stop(now());
  expect_standing(Hold::kLatched);
  EXPECT_EQ(output().state, GateState::kLatched);
  for (int i = 0; i < 100; ++i) {
    pass(100 * kMs);
    clock();
    ASSERT_TRUE(guard());
    ASSERT_TRUE(planner(0.3));
    ASSERT_TRUE(person(7, 0.3));
    expect_standing(Hold::kLatched);
  }
  expect_refused(gate_.release(false, stamp(3, now()), now()), "not_a_person");
  expect_refused(gate_.release(true, stamp(3, now() - 300 * kMs), now()), "stale");
  expect_standing(Hold::kLatched);
  ASSERT_TRUE(gate_.release(true, stamp(3, now()), now()));
  expect_standing(Hold::kNobody);
}

TEST_F(CommandGateTest, HazardM08_AReleaseFromBeforeTheLastStopIsRefused) {
  all_well();
  gate_.stop(now());
  pass(10 * kMs);
  const SentStamp before = stamp(3, now());
  pass(10 * kMs);
  gate_.stop(now());
  expect_refused(gate_.release(true, before, now()), "stale");
  expect_standing(Hold::kLatched);
}

TEST_F(CommandGateTest, HazardM09_AReleaseRevivesNothing) {
  all_well();
  ASSERT_TRUE(planner(0.3));
  ASSERT_TRUE(person(7, 0.2));
  gate_.stop(now());
  pass(kMs);
  ASSERT_TRUE(planner(0.4));
  const DriveOrder underway{{now(), 1, sequence_ + 1}, Driver::kPlanner, 0, 0.4, 0};
  sequence_ += 10;
  pass(kMs);
  ASSERT_TRUE(gate_.release(true, stamp(3, now()), now()));
  expect_standing(Hold::kNobody);
  // Sent while it was latched, and here only now.
  ASSERT_TRUE(gate_.drive(underway, now()));
  expect_standing(Hold::kNobody);
  pass(kMs);
  ASSERT_TRUE(planner(0.1));
  expect_driving(0.1, 0);
}

TEST_F(CommandGateTest, ALatchThatWasKeptHoldsFromTheStart) {
  CommandGate kept(kLimits, true, now());
  pass(kMs);
  kept.clock(data_now(), now(), now());
  ASSERT_TRUE(kept.permit({stamp(2, now()), 0.5, data_now()}, now()));
  ASSERT_TRUE(kept.drive({stamp(1, now()), Driver::kPlanner, 0, 0.3, 0}, now()));
  EXPECT_EQ(kept.output(now(), data_now()).state, GateState::kLatched);
  expect_refused(kept.release(true, {kStart_us - 1, 3, 1}, now()), "stale");
  EXPECT_TRUE(kept.release(true, {now(), 3, 1}, now()));
}

TEST_F(CommandGateTest, APersonBeatsThePlannerForTheLengthOfALease) {
  all_well();
  ASSERT_TRUE(planner(0.3));
  ASSERT_TRUE(person(7, -0.2));
  expect_driving(-0.2, 0);
  ASSERT_TRUE(planner(0.3));
  expect_driving(-0.2, 0);
  pass(CommandGate::kMaxCommandAge_us + 1);
  clock();
  ASSERT_TRUE(planner(0.3));
  ASSERT_TRUE(guard());
  expect_standing(Hold::kSilent);
  pass(CommandGate::kLease_us - CommandGate::kMaxCommandAge_us);
  clock();
  ASSERT_TRUE(guard());
  ASSERT_TRUE(planner(0.3));
  expect_driving(0.3, 0);
}

TEST_F(CommandGateTest, OnePersonDrivesAtATimeAndNoneWithoutALease) {
  all_well();
  expect_refused(person(0, 0.2), "lease");
  ASSERT_TRUE(person(7, -0.2));
  expect_refused(person(8, 0.2), "lease");
  expect_driving(-0.2, 0);
  pass(CommandGate::kLease_us + 1);
  clock();
  ASSERT_TRUE(person(8, -0.1));
  expect_driving(-0.1, 0);
}

TEST_F(CommandGateTest, WhatIsForgottenIsNotRevived) {
  all_well();
  ASSERT_TRUE(planner(0.3));
  gate_.forget(now());
  expect_standing(Hold::kNobody);
  pass(kMs);
  ASSERT_TRUE(planner(0.2));
  expect_driving(0.2, 0);
}

TEST_F(CommandGateTest, WhereTurnAndSpeedDoNotBothFitTheTurnIsKept) {
  all_well();
  ASSERT_TRUE(planner(0.5, 1.0));
  EXPECT_DOUBLE_EQ(output().turn_radps, 1.0);
  EXPECT_DOUBLE_EQ(output().forward_mps, 0.5 - 0.13);
  // Tracks so slow that the turn alone is too much for them.
  CommandGate slow({0.1, 1.0, 0.3}, false, kStart_us);
  slow.clock(data_now(), now(), now());
  ASSERT_TRUE(slow.permit({stamp(2, now()), 0.5, data_now()}, now()));
  ASSERT_TRUE(slow.drive({stamp(1, now()), Driver::kPlanner, 0, -0.1, -1.0}, now()));
  const GateOutput out = slow.output(now(), data_now());
  EXPECT_NEAR(out.turn_radps, -0.1 / 0.15, 1e-12);
  EXPECT_NEAR(out.forward_mps, 0, 1e-12);
}

/// What was sent, so that an output can be traced to its order: every order has a turn of its own.
struct Sent {
  DriveOrder order;
  HostTime arrives_us;
};

TEST(CommandGateProperty,
     HazardM10_OfAMillionRandomOrdersNoneMovesTheRobotLaterThan250MsAfterSending) {
  constexpr int kOrders = 1'000'000;
  std::mt19937_64 random(20240229);
  std::uniform_real_distribution<double> uniform(0, 1);
  const auto chance = [&](double share) { return uniform(random) < share; };
  CommandGate gate(kLimits, false, 0);
  std::vector<Sent> underway;
  std::vector<DriveOrder> by_number(kOrders);
  std::int64_t moved = 0;
  std::int64_t refused = 0;
  std::int64_t stops = 0;
  HostTime stopped_us = 0;
  HostTime now_us = 0;
  std::int64_t planner_session = 1;
  HostTime permitted_us = -1'000'000;
  double permitted_mps = 0;
  for (int number = 0; number < kOrders; ++number) {
    now_us += static_cast<HostTime>(uniform(random) * (chance(0.01) ? 600'000 : 20'000));
    const Utime data_us = now_us + kData_us;
    if (chance(0.9)) gate.clock(data_us, now_us, now_us);
    if (chance(0.7)) {
      const double allowed = chance(0.1) ? std::nan("") : uniform(random) - 0.2;
      const HostTime sent_us = now_us - static_cast<HostTime>(uniform(random) * 300'000);
      const Verdict taken = gate.permit({{sent_us, 2, number}, allowed, data_us - 50'000}, now_us);
      if (taken) {
        permitted_us = sent_us;
        permitted_mps = allowed;
      } else if (taken.error().kind == std::string("not_finite")) {
        permitted_us = -1'000'000;
      }
    }
    if (chance(0.0005)) {
      gate.stop(now_us);
      stopped_us = now_us;
      ++stops;
    }
    if (gate.latched() && chance(0.1)) {
      if (gate.release(chance(0.5),
                       {now_us - static_cast<HostTime>(uniform(random) * 1000), 3, number},
                       now_us)) {
        EXPECT_TRUE(gate.output(now_us, data_us).stands());
      }
    }
    DriveOrder order;
    order.driver = chance(0.2) ? Driver::kPerson : Driver::kPlanner;
    if (chance(0.001)) ++planner_session;
    order.stamp = {now_us, order.driver == Driver::kPerson ? 1000 : planner_session, number};
    order.lease = order.driver == Driver::kPerson ? 1 + number / 5000 % 3 : 0;
    order.forward_mps = uniform(random) * 1.1 - 0.55;
    // Below every limit, so that it comes out as it went in.
    order.turn_radps = 1e-7 * (1 + number);
    if (chance(0.02)) order.forward_mps = chance(0.5) ? std::nan("") : 1e12;
    if (chance(0.02)) order.stamp.sent_us += static_cast<HostTime>(uniform(random) * 1e6);
    by_number[static_cast<std::size_t>(number)] = order;
    underway.push_back({order, now_us + static_cast<HostTime>(std::pow(uniform(random), 8) * 1e6)});
    for (std::size_t i = 0; i < underway.size();) {
      if (underway[i].arrives_us > now_us) {
        ++i;
        continue;
      }
      if (!gate.drive(underway[i].order, now_us)) ++refused;
      if (chance(0.99)) {
        underway[i] = underway.back();
        underway.pop_back();
      } else {
        underway[i].arrives_us += 30'000;  // it will come once more
      }
    }
    const GateOutput out = gate.output(now_us, data_us);
    ASSERT_TRUE(std::isfinite(out.forward_mps) && std::isfinite(out.turn_radps));
    ASSERT_LE(std::abs(out.forward_mps) + std::abs(out.turn_radps) * kLimits.track_gauge_m / 2,
              kLimits.max_speed_mps + 1e-12);
    ASSERT_TRUE(out.stands() || !gate.latched());
    if (out.stands()) {
      ASSERT_EQ(out.forward_mps, 0);
      ASSERT_EQ(out.turn_radps, 0);
      continue;
    }
    ++moved;
    const auto cause = static_cast<std::size_t>(std::llround(out.turn_radps / 1e-7) - 1);
    const DriveOrder& by = by_number.at(cause);
    ASSERT_DOUBLE_EQ(by.turn_radps, out.turn_radps);
    ASSERT_GE(by.stamp.sent_us, now_us - 250'000);
    ASSERT_GT(by.stamp.sent_us, stopped_us);
    ASSERT_LE(out.forward_mps, std::max(by.forward_mps, 0.0));
    if (out.forward_mps > 0) {
      ASSERT_GE(permitted_us, now_us - 200'000);
      ASSERT_LE(out.forward_mps, permitted_mps);
    }
  }
  EXPECT_GT(moved, kOrders / 4) << "the gate must open, too";
  EXPECT_GT(refused, kOrders / 100);
  EXPECT_GT(stops, 100);
  RecordProperty("moved", std::to_string(moved));
}

}  // namespace
}  // namespace cairn::motor
