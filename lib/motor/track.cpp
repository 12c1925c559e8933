// SPDX-License-Identifier: Apache-2.0
#include "motor/track.hpp"

#include <cmath>

namespace cairn::motor {

void Track::add(std::int64_t device_us, std::int64_t ticks, double duty) {
  speed_.add(device_us, ticks);
  watch_for_stall(device_us, duty);
}

void Track::watch_for_stall(std::int64_t device_us, double duty) {
  const double free_mps = duty * full_duty_mps_;
  const bool free = std::abs(free_mps) < kStallDrive_mps ||
                    speed_.mps() * (free_mps > 0 ? 1 : -1) >= kStallShare * std::abs(free_mps);
  if (free || !any_) free_us_ = device_us;
  any_ = true;
  stalled_ = device_us - free_us_ >= kStall_us;
}

double Track::step(double target_mps, double dt_s) {
  const double duty = pid_.step(target_mps, speed_.mps(), dt_s);
  const bool stands =
      target_mps == 0 && pid_.setpoint_mps() == 0 && std::abs(speed_.mps()) < kStanding_mps;
  if (!stands) return duty;
  pid_.reset();
  return 0;
}

void Track::restart() {
  pid_.reset();
  speed_.restart();
  any_ = false;
  stalled_ = false;
}

}  // namespace cairn::motor
