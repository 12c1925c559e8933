// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "procs/cli/demo_plan.hpp"
#include "procs/cli/run_results.hpp"
#include "procs/cli/simulated_place.hpp"
#include "procs/supervisor/group_config.hpp"

namespace cairn::cli {

/// The process group of a live demo: config/groups/simulation.yaml as the plan has it.
[[nodiscard]] Result<GroupConfig> demo_group(const DemoPlan& plan);

/// Runs the demo as life does: the group as processes of their own under a supervisor that is kept
/// alive; any of them may die at any moment. Ends when planner has explored all that it can reach,
/// at the time limit, on a stop signal, or when the group is given up; then the group is taken
/// down. An error: the group did not come up or go down.
[[nodiscard]] Result<RunResults> run_live_demo(const DemoPlan& plan, const GroupConfig& group,
                                               SimulatedPlace& place);

/// Runs the demo as fast as it goes, in this process, without sockets: the simulator says what
/// stereo and odometry would have said of true depth and motion (`fast`), all other processes are
/// the robot's own. The same plan gives the same bytes. For statistics only.
[[nodiscard]] Result<RunResults> run_fast_demo(const DemoPlan& plan, SimulatedPlace& place);

}  // namespace cairn::cli
