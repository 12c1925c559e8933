// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "core/config.hpp"

namespace cairn::simulation {

/// What becomes of a motor's duty on the way to the ground.
struct TracksConfig {
  double full_duty_mps = 0.8;
  double time_constant_s = 0.08;
  double left_slip = 0.03;
  double right_slip = 0.03;
  double slip_noise = 0.02;
  double effective_gauge_ratio = 1.35;

  void visit(ConfigVisitor& v) {
    v.number("full_duty_mps", full_duty_mps, {0.05, 20}, "m/s",
             "speed that a track reaches at full duty");
    v.number("time_constant_s", time_constant_s, {0.005, 5}, "s",
             "after which a track has taken up 63 % of a new speed");
    v.number("left_slip", left_slip, {-0.5, 0.95}, "",
             "share of the left track's motion that is lost on the ground, on average");
    v.number("right_slip", right_slip, {-0.5, 0.95}, "",
             "share of the right track's motion that is lost on the ground, on average");
    v.number("slip_noise", slip_noise, {0, 0.3}, "",
             "standard deviation of either track's share, which wanders within half a second");
    v.number("effective_gauge_ratio", effective_gauge_ratio, {1, 4}, "",
             "the body turns as if its tracks were so many times farther apart than they are, for "
             "tracks slip sideways in a turn");
  }
};

/// One track: its motor answers a duty with a delay of first order; some of its motion is lost on
/// the ground. Exact for a duty that stays, however the time is cut into steps.
class TrackDrive {
 public:
  TrackDrive(const TracksConfig& config, double mean_slip, std::uint64_t seed)
      : config_{config}, mean_slip_{mean_slip}, slip_{mean_slip}, seed_{seed} {}

  /// `duty`: share of full drive, -1 to 1.
  void step(double duty, double dt_s);

  /// Way of the track since its start, forward is positive [m].
  [[nodiscard]] double way_m() const { return way_m_; }
  /// Its mean speed during the step.
  [[nodiscard]] double mps() const { return mean_mps_; }
  /// What of that takes hold on the ground.
  [[nodiscard]] double ground_mps() const { return mean_mps_ * (1 - slip_); }

 private:
  void let_slip_wander(double dt_s);

  TracksConfig config_;
  double mean_slip_;
  double slip_;
  std::uint64_t seed_;
  std::uint64_t steps_ = 0;
  double now_mps_ = 0;
  double mean_mps_ = 0;
  double way_m_ = 0;
};

}  // namespace cairn::simulation
