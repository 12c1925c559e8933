// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "procs/cli/run_plan.hpp"
#include "procs/simulator/simulator_config.hpp"

namespace cairn::cli {

/// What `cairn demo` runs: the simulated robot, told to explore.
struct DemoPlan {
  RunPlan run;
  std::string world;  ///< file; empty: the room that ships
  int seed = 1;
  int people = 0;
  bool fast = false;
  double time_limit_s = 3600;  ///< of data time

  // What complete() finds.
  SimulatorConfig simulator;
  int max_disparity_px = 0;  ///< bounds what stereo sees of what is near
};

/// The plan with what its options come to as settings of processes, and a config file where it
/// names none. Touches no file.
[[nodiscard]] DemoPlan with_settings(DemoPlan plan);

/// Fills in what is found in the config, which check_config of plan.run has found good.
[[nodiscard]] Result<DemoPlan> complete(DemoPlan plan);

}  // namespace cairn::cli
