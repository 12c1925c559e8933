// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "core/result.hpp"
#include "motor/track_pid.hpp"

namespace cairn::motor {

/// Where a track was, `t_s` after a duty came into effect that it did not have before.
struct StepPoint {
  double t_s;
  double way_m;
};

struct StepFit {
  double full_duty_mps;  ///< speed at full duty, taken to rise in proportion
  double response_s;     ///< how much later than its duty a track is where it would be without lag
};

/// What a step of `duty` shows of a track. At constant speed v it is v (t - response) from its
/// start, however its lag is made up (the area method: Astrom and Hagglund 2006, section 2.7). The
/// error says what is wrong: too few points, no motion, motion the other way, no constant speed.
[[nodiscard]] Result<StepFit> fit_step(const std::vector<StepPoint>& points, double duty);

/// Settings for a track like this: the loop as fast, against the track's own lag and that of
/// measuring, as the defaults are on the track that they were chosen for.
[[nodiscard]] TrackPidConfig settings_for(const StepFit& fit);

}  // namespace cairn::motor
