// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "procs/cli/run_plan.hpp"
#include "procs/cli/run_results.hpp"

namespace cairn::cli {

/// Runs the recording through live processes over UDP: starts stereo, odometry, localizer and
/// mapper, waits until each has been heard, plays the source at plan.speed, waits until its last
/// frame is worked off, stops them, reports. What a process prints lands in
/// plan.out/log/PROCESS.log.
[[nodiscard]] Result<RunResults> run_live(const RunPlan& plan);

}  // namespace cairn::cli
