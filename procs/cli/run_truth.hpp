// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>

#include "evaluation/report.hpp"
#include "evaluation/trajectory.hpp"
#include "mapping/voxel_map.hpp"

namespace cairn::cli {

/// What is true of a run, as far as anybody knows. Only its report is made of it.
struct RunTruth {
  evaluation::Trajectory T_truth_body;  ///< empty: unknown
  std::optional<double> coverage;       ///< share of the reachable free floor that was seen
  /// Scores a map of the run; only what is measured is set. Empty: nobody can.
  std::function<Result<evaluation::MapReport>(const mapping::VoxelMap& map,
                                              const Isometry& T_truth_map)>
      score_map;
};

}  // namespace cairn::cli
