// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "procs/cli/run_plan.hpp"
#include "procs/cli/run_truth.hpp"

namespace cairn::cli {

/// What is true of a replay: the trajectory of the plan's truth file, else the TRUTH that a
/// simulated run's recording holds, else nothing.
[[nodiscard]] Result<RunTruth> source_truth(const RunPlan& plan);

}  // namespace cairn::cli
