// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "evaluation/report.hpp"
#include "evaluation/trajectory_score.hpp"
#include "procs/cli/run_plan.hpp"
#include "procs/cli/run_recorder.hpp"
#include "procs/cli/run_truth.hpp"

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
  std::string mode = "full";
  bool live = false;  ///< processes of their own, in host time: latencies and processor time count
  std::optional<double> realtime_factor;
  std::map<std::string, std::uint64_t> restarts;  ///< where more is known than was heard
};

/// Writes trajectory.tum, trajectory_final.tum, truth.tum, map.cairn, map.png and report.json into
/// plan.out.
[[nodiscard]] Result<RunResults> write_results(const RunPlan& plan, const RunRecorder& recorder,
                                               const RunEnd& end, const RunTruth& truth);

/// The same on standard output: report.json itself, or words for people.
void print_results(const RunPlan& plan, const RunResults& results, bool json);

}  // namespace cairn::cli
