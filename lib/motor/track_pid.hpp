// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/config.hpp"

namespace cairn::motor {

struct TrackPidConfig {
  double full_duty_mps = 0.8;
  double response_s = 0.15;
  double proportional = 1;
  double integral = 6;
  double derivative = 0;
  double max_braking_mps2 = 3;

  void visit(ConfigVisitor& v) {
    v.number("full_duty_mps", full_duty_mps, {0.05, 20}, "m/s",
             "speed of a track at full duty: the feed-forward");
    v.number("response_s", response_s, {0, 2}, "s",
             "in which a track follows its duty, and its encoder tells: so much later than the "
             "set-point is the speed expected");
    v.number("proportional", proportional, {0, 20}, "s/m", "duty per error of speed");
    v.number("integral", integral, {0, 200}, "1/m", "duty per error of speed and second");
    v.number("derivative", derivative, {0, 5}, "s^2/m", "duty per acceleration, against it");
    v.number(
        "max_braking_mps2", max_braking_mps2, {0.05, 50}, "m/s^2",
        "by how much a track may be slowed down; it is sped up by robot.max_acceleration_mps2");
  }
};

/// Holds one track at a speed: feed-forward of the set-point plus PID on how far the measured speed
/// is off the one that a first-order track would have by now (two degrees of freedom: Astrom and
/// Hagglund 2006, section 5.3), so that the integral learns the track and not its lag. The
/// set-point comes to the target at a limited rate; the integral is held where the duty is at its
/// limit and the error would drive it further.
class TrackPid {
 public:
  TrackPid(const TrackPidConfig& config, double max_acceleration_mps2)
      : config_{config}, max_acceleration_mps2_{max_acceleration_mps2} {}

  /// The duty, -1 to 1, for the next `dt_s` seconds (0 to 0.1; more counts as 0.1).
  [[nodiscard]] double step(double target_mps, double measured_mps, double dt_s);

  /// Stands still; the next step starts from there.
  void reset();

  /// What the track is held at now.
  [[nodiscard]] double setpoint_mps() const { return setpoint_mps_; }

 private:
  void approach(double target_mps, double dt_s);

  TrackPidConfig config_;
  double max_acceleration_mps2_;
  double setpoint_mps_ = 0;
  double expected_mps_ = 0;
  double integral_ = 0;
  double last_measured_mps_ = 0;
  bool stepped_ = false;
};

}  // namespace cairn::motor
