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

}  // namespace cairn::simulation
