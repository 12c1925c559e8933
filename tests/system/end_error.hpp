// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "camera/frame_source.hpp"
#include "evaluation/trajectory_score.hpp"
#include "procs/cli/truth.hpp"

namespace cairn::testing {

/// How far off the last pose is, as a share of the way, when the trajectory is laid over the
/// dataset's truth at the first pose alone.
[[nodiscard]] inline double end_error_fraction(const evaluation::Trajectory& estimate,
                                               const std::filesystem::path& dataset) {
  const auto opened = camera::open_dataset(dataset.string()).value();
  const auto truth = cli::read_body_truth(opened.info.truth_file, opened.info.truth_format,
                                          opened.info.truth_frame, opened.info.utimes,
                                          opened.frames->rig().T_body_left)
                         .value();
  return evaluation::score_trajectory(estimate, truth).value().end.fraction_of_way.value();
}

}  // namespace cairn::testing
