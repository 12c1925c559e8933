// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "camera/rig_calibration.hpp"
#include "evaluation/trajectory.hpp"
#include "procs/cli/run_results.hpp"
#include "simulation/world.hpp"

namespace cairn::cli {

/// Scores a map against the world that it is of, as far as it could be seen on the way
/// `T_world_body`. World and rig must outlive the result.
[[nodiscard]] ScoreMap map_against_world(const simulation::World& world,
                                         const camera::RigCalibration& rig,
                                         const evaluation::Trajectory& T_world_body);

}  // namespace cairn::cli
