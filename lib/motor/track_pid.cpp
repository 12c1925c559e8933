// SPDX-License-Identifier: Apache-2.0
#include "motor/track_pid.hpp"

#include <algorithm>
#include <cmath>

namespace cairn::motor {
namespace {

constexpr double kMaxStep_s = 0.1;

}  // namespace

void TrackPid::reset() {
  setpoint_mps_ = 0;
  expected_mps_ = 0;
  integral_ = 0;
  stepped_ = false;
}

// Towards zero as hard as brakes may, away from it as gently as the robot wants; through zero it is
// the one, then, in the next step, the other.
void TrackPid::approach(double target_mps, double dt_s) {
  const bool braking =
      setpoint_mps_ * target_mps < 0 || std::abs(target_mps) < std::abs(setpoint_mps_);
  const double goal_mps = setpoint_mps_ * target_mps < 0 ? 0 : target_mps;
  const double step_mps =
      dt_s * (braking ? std::max(config_.max_braking_mps2, max_acceleration_mps2_)
                      : max_acceleration_mps2_);
  setpoint_mps_ += std::clamp(goal_mps - setpoint_mps_, -step_mps, step_mps);
  const double share = config_.response_s > 0 ? -std::expm1(-dt_s / config_.response_s) : 1;
  expected_mps_ += share * (setpoint_mps_ - expected_mps_);
}

double TrackPid::step(double target_mps, double measured_mps, double dt_s) {
  dt_s = std::clamp(dt_s, 0.0, kMaxStep_s);
  approach(target_mps, dt_s);
  const double error_mps = expected_mps_ - measured_mps;
  const double acceleration_mps2 =
      stepped_ && dt_s > 0 ? (measured_mps - last_measured_mps_) / dt_s : 0;
  last_measured_mps_ = measured_mps;
  stepped_ = true;
  const double gain = config_.integral * error_mps * dt_s;
  const double duty = setpoint_mps_ / config_.full_duty_mps + config_.proportional * error_mps +
                      integral_ + gain - config_.derivative * acceleration_mps2;
  const bool winding_up = (duty > 1 && gain > 0) || (duty < -1 && gain < 0);
  if (!winding_up) integral_ = std::clamp(integral_ + gain, -1.0, 1.0);
  return std::clamp(duty, -1.0, 1.0);
}

}  // namespace cairn::motor
