// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "evaluation/report.hpp"
#include "evaluation/trajectory_score.hpp"
#include "mapping/voxel_map.hpp"
#include "procs/cli/run_plan.hpp"
#include "procs/cli/run_recorder.hpp"

namespace cairn::cli {

/// What a run came to.
struct RunResults {
  evaluation::Report report;
  std::optional<evaluation::TrajectoryScore> score;  ///< where there is a truth
  std::size_t frames = 0;
};

/// How a run ended, besides what was heard of it.
struct RunEnd {
  bool finished = false;
  std::string reason;
  bool latencies_count = false;  ///< host time was real
  std::optional<double> realtime_factor;
};

/// Scores the map of a run; `T_truth_map` lays it over the truth. Only what is measured is set.
using ScoreMap = std::function<Result<evaluation::MapReport>(const mapping::VoxelMap& map,
                                                             const Isometry& T_truth_map)>;

/// Writes trajectory.tum, truth.tum, map.cairn, map.png and report.json into plan.out.
[[nodiscard]] Result<RunResults> write_results(const RunPlan& plan, const RunRecorder& recorder,
                                               const RunEnd& end, const ScoreMap& score_map = {});

/// The same on standard output: report.json itself, or words for people.
void print_results(const RunPlan& plan, const RunResults& results, bool json);

}  // namespace cairn::cli
