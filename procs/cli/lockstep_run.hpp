// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "procs/cli/run_plan.hpp"
#include "procs/cli/run_results.hpp"

namespace cairn::cli {

/// Runs the recording through the same node classes as live, in this process, without sockets, as
/// fast as it goes. The same plan gives the same bytes, on any number of threads.
[[nodiscard]] Result<RunResults> run_lockstep(const RunPlan& plan);

}  // namespace cairn::cli
