// SPDX-License-Identifier: Apache-2.0
#include "motor/track_pid.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <limits>
#include <random>

#include "wheel_rig.hpp"

namespace cairn::motor {
namespace {

constexpr double kAtOnce_mps2 = 1e12;

// With e = r - v, z' = e, the plant lag v' = (K u - v) / lag and u = r/K + P e + I z:
//   lag e'' + (1 + K P) e' + K I e = 0,  e(0) = r,  e'(0) = -(1 + K P) r / lag.
double closed_form_error(const TrackPidConfig& pid, double lag_s, double r, double t_s) {
  const double k = pid.full_duty_mps;
  const double b = (1 + k * pid.proportional) / lag_s;
  const double c = k * pid.integral / lag_s;
  const double root = std::sqrt(b * b / 4 - c);
  const double s1 = -b / 2 + root;
  const double s2 = -b / 2 - root;
  const double second = (-b - s1) / (s2 - s1);
  return r * ((1 - second) * std::exp(s1 * t_s) + second * std::exp(s2 * t_s));
}

TEST(TrackPid, StepResponseIsTheClosedFormOfAFirstOrderPlant) {
  TrackPidConfig config;
  config.response_s = 0;
  config.proportional = 0.6;
  config.integral = 4;
  for (const double lag_s : {0.05, 0.1, 0.15}) {
    TrackPid pid(config, kAtOnce_mps2);
    testing::Plant plant;
    plant.lag_s = lag_s;
    constexpr double kStep_s = 1e-4;
    constexpr double kTarget_mps = 0.3;  // the duty stays below 1
    double worst_mps = 0;
    for (int i = 0; i < 20'000; ++i) {
      const double expected_mps =
          kTarget_mps - closed_form_error(config, lag_s, kTarget_mps, i * kStep_s);
      worst_mps = std::max(worst_mps, std::abs(plant.speed_mps - expected_mps));
      plant.run(pid.step(kTarget_mps, plant.speed_mps, kStep_s), kStep_s);
    }
    EXPECT_LT(worst_mps, 1e-3 * kTarget_mps) << "lag " << lag_s;
  }
}

TEST(TrackPid, TheFeedForwardAloneHoldsAPlantThatIsAsExpected) {
  TrackPidConfig config;
  config.proportional = config.integral = 0;
  TrackPid pid(config, kAtOnce_mps2);
  EXPECT_DOUBLE_EQ(pid.step(0.4, 0.123, 0.02), 0.5);
}

TEST(TrackPid, TheIntegralTakesOverWhatThePlantIsWeaker) {
  TrackPid pid({}, 1);
  testing::Plant plant;
  plant.full_duty_mps = 0.5;
  for (int i = 0; i < 300; ++i) plant.run(pid.step(0.3, plant.speed_mps, 0.02), 0.02);
  EXPECT_NEAR(plant.speed_mps, 0.3, 1e-4);
}

TEST(TrackPid, TheSetpointRisesAsTheRobotMayAndFallsAsItsBrakesMay) {
  TrackPidConfig config;
  config.max_braking_mps2 = 4;
  TrackPid pid(config, 1);
  const auto run = [&](double target_mps, int steps) {
    for (int i = 0; i < steps; ++i) (void)pid.step(target_mps, pid.setpoint_mps(), 0.02);
    return pid.setpoint_mps();
  };
  EXPECT_NEAR(run(0.5, 10), 0.2, 1e-12);
  EXPECT_NEAR(run(0.5, 20), 0.5, 1e-12);
  EXPECT_NEAR(run(0, 5), 0.1, 1e-12);
  EXPECT_NEAR(run(-0.5, 2), 0, 1e-12) << "through zero it brakes first";
  EXPECT_NEAR(run(-0.5, 10), -0.2, 1e-12);
  EXPECT_NEAR(run(-0.1, 1), -0.12, 1e-12);
}

/// How long a track that was held for 5 s is over its target by a twentieth when it comes free.
double over_after_held_s(const std::function<double(double measured_mps)>& duty) {
  testing::Plant plant;
  plant.blocked = true;
  for (int i = 0; i < 250; ++i) plant.run(duty(plant.speed_mps), 0.02);
  plant.blocked = false;
  double last_over_s = 0;
  for (int i = 0; i < 1000; ++i) {
    plant.run(duty(plant.speed_mps), 0.02);
    if (plant.speed_mps > 0.4 * 1.05) last_over_s = i * 0.02;
  }
  return last_over_s;
}

TEST(TrackPid, TheIntegralDoesNotWindUpWhileATrackIsHeld) {
  TrackPid pid({}, 1);
  const double ours_s =
      over_after_held_s([&](double measured_mps) { return pid.step(0.4, measured_mps, 0.02); });
  // The same gains, with an integral that knows no limit.
  const TrackPidConfig config;
  double integral = 0;
  const double winding_up_s = over_after_held_s([&](double measured_mps) {
    const double error_mps = 0.4 - measured_mps;
    integral += config.integral * error_mps * 0.02;
    return std::clamp(0.4 / config.full_duty_mps + config.proportional * error_mps + integral, -1.0,
                      1.0);
  });
  std::printf("over the target for %.2f s; without a limit %.2f s\n", ours_s, winding_up_s);
  EXPECT_LT(ours_s, 1);
  EXPECT_GT(winding_up_s, 5 * ours_s);
}

TEST(TrackPid, StartsFromStandingAfterAReset) {
  TrackPid pid({}, 1);
  const double first = pid.step(0.4, 0, 0.02);
  for (int i = 0; i < 50; ++i) (void)pid.step(0.4, 0.1, 0.02);
  pid.reset();
  EXPECT_EQ(pid.setpoint_mps(), 0);
  EXPECT_EQ(pid.step(0.4, 0, 0.02), first);
}

TEST(TrackPid, WhateverIsMeasuredTheDutyIsWithinItsLimits) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> uniform(-1, 1);
  TrackPidConfig config;
  config.derivative = 0.1;
  TrackPid pid(config, 1);
  for (int i = 0; i < 200'000; ++i) {
    const double scale = std::pow(10, 12 * uniform(random));
    const double duty = pid.step(uniform(random), scale * uniform(random), uniform(random));
    ASSERT_TRUE(duty >= -1 && duty <= 1) << duty;
  }
}

/// As a real track is driven: 50 readings a second, each by 30 ms old, in ticks; a motor that is
/// stronger or weaker than the config says.
struct Course {
  double overshoot;
  double settled_after_s;
};

Course drive(double strength, double lag_s, double target_mps) {
  TrackPid pid({}, 1);
  testing::Plant plant;
  plant.full_duty_mps *= strength;
  plant.lag_s = lag_s;
  double ways[4] = {};
  double most_mps = 0;
  double last_off_s = 0;
  for (int i = 0; i < 250; ++i) {
    for (int k = 0; k < 3; ++k) ways[k] = ways[k + 1];
    ways[3] = static_cast<double>(plant.ticks()) / plant.ticks_per_m;
    const double duty = pid.step(target_mps, (ways[3] - ways[0]) / 0.06, 0.02);
    for (int ms = 0; ms < 20; ++ms) plant.run(duty, 0.001);
    most_mps = std::max(most_mps, plant.speed_mps);
    if (std::abs(plant.speed_mps - target_mps) > 0.05 * target_mps) last_off_s = i * 0.02;
  }
  return {most_mps / target_mps - 1, last_off_s};
}

TEST(TrackPid, TheDefaultsHoldMotorsOfManyKinds) {
  double worst_overshoot = 0;
  double overshoot_as_configured = 0;
  double slowest_s = 0;
  for (const double strength : {0.75, 1.0, 1.4}) {
    for (const double lag_s : {0.03, 0.08, 0.15, 0.3}) {
      for (const double target_mps : {0.1, 0.3, 0.5}) {
        const Course course = drive(strength, lag_s, target_mps);
        worst_overshoot = std::max(worst_overshoot, course.overshoot);
        slowest_s = std::max(slowest_s, course.settled_after_s);
        if (strength == 1 && lag_s <= 0.15)
          overshoot_as_configured = std::max(overshoot_as_configured, course.overshoot);
      }
    }
  }
  std::printf(
      "worst overshoot %.1f %% (%.1f %% where the motors are as configured), within 5 %% "
      "after at most %.2f s\n",
      100 * worst_overshoot, 100 * overshoot_as_configured, slowest_s);
  EXPECT_LT(worst_overshoot, 0.2);
  EXPECT_LT(overshoot_as_configured, 0.05);
  EXPECT_LT(slowest_s, 1.5);
}

}  // namespace
}  // namespace cairn::motor
