// SPDX-License-Identifier: Apache-2.0
#include "simulation/track_drive.hpp"

#include <cmath>

#include "simulation/random_normal.hpp"

namespace cairn::simulation {
namespace {

constexpr double kSlipMemory_s = 0.5;

}  // namespace

void TrackDrive::step(double duty, double dt_s) {
  let_slip_wander(dt_s);
  const double target_mps = duty * config_.full_duty_mps;
  const double answered = 1 - std::exp(-dt_s / config_.time_constant_s);
  const double way_m =
      target_mps * dt_s + (now_mps_ - target_mps) * config_.time_constant_s * answered;
  now_mps_ += (target_mps - now_mps_) * answered;
  mean_mps_ = way_m / dt_s;
  way_m_ += way_m;
}

// An Ornstein-Uhlenbeck process (1930) round the mean, exact for any step.
void TrackDrive::let_slip_wander(double dt_s) {
  const double kept = std::exp(-dt_s / kSlipMemory_s);
  const double deviation = slip_ - mean_slip_;
  const double push = config_.slip_noise * std::sqrt(1 - kept * kept);
  slip_ = mean_slip_ + kept * deviation + push * normal_random(hash64(seed_, steps_++));
}

}  // namespace cairn::simulation
