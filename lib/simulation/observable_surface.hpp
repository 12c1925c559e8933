// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "camera/rig_calibration.hpp"
#include "core/geometry.hpp"
#include "core/result.hpp"
#include "evaluation/trajectory.hpp"
#include "simulation/world.hpp"

namespace cairn::simulation {

struct ObservableConfig {
  double spacing_m = 0.01;  ///< side of the cells that each face is cut into: one point a cell
  double min_range_m = 0;   ///< nearer than what the matcher searches is not observable
  double max_range_m = 3;
  int pixel_step = 2;  ///< a ray through every how many pixels
};

/// Points on the world's surfaces that both cameras of a rig see from some pose T_world_body of the
/// path, each at a distance from the left camera within the range. In the world frame, in a fixed
/// order.
[[nodiscard]] Result<std::vector<Eigen::Vector3d>> observable_surface(
    const World& world, const camera::RigCalibration& rig,
    std::span<const evaluation::StampedPose> path, const ObservableConfig& config);

}  // namespace cairn::simulation
