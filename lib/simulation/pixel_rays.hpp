// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "camera/rig_calibration.hpp"
#include "core/result.hpp"

namespace cairn::simulation {

/// Ray (x, y, 1) in camera axes of every pixel's centre, row by row: the inverse of the camera's
/// model. Fails where the model cannot be inverted inside the image.
[[nodiscard]] Result<std::vector<Eigen::Vector3f>> pixel_rays(const camera::CameraModel& camera,
                                                              int width_px, int height_px);

/// Where a point in camera axes appears [px]. Nothing for a point behind the camera; far outside
/// the image the answer of a bent lens means nothing.
[[nodiscard]] std::optional<Eigen::Vector2d> project(const camera::CameraModel& camera,
                                                     const Eigen::Vector3d& point_m);

}  // namespace cairn::simulation
