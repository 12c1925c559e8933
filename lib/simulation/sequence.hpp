// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>

#include "camera/rig_calibration.hpp"
#include "core/result.hpp"
#include "evaluation/trajectory.hpp"
#include "simulation/renderer.hpp"
#include "simulation/world.hpp"

namespace cairn::simulation {

struct SequenceConfig {
  double rate_hz = 15;  ///< frame i is taken at i / rate_hz, whatever the path's times say
  std::uint64_t seed = 1;
  SensorConfig sensor;
  double map_resolution_m = 0.02;  ///< what the dataset says suits the place
  double map_max_range_m = 4;
};

/// Called after every frame: frames done, frames in all.
using Progress = std::function<void(std::size_t, std::size_t)>;

/// Renders a recording that open_dataset reads: left/ and right/ (000000.png and on), truth.txt
/// (TUM, T_world_body), and dataset.yaml, which is written last: a folder that holds one is whole.
/// One frame for each pose of the path. The rig must be a rectified one. An existing dataset.yaml
/// is removed first, and images that this recording does not have must not lie there: the folder
/// has to be new or empty, or hold an earlier recording of as many frames or fewer.
[[nodiscard]] Result<void> render_sequence(const World& world, const camera::RigCalibration& rig,
                                           const evaluation::Trajectory& path,
                                           const SequenceConfig& config,
                                           const std::filesystem::path& folder,
                                           const Progress& progress);

}  // namespace cairn::simulation
