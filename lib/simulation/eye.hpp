// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "camera/rig_calibration.hpp"
#include "core/geometry.hpp"
#include "core/result.hpp"

namespace cairn::simulation {

/// One camera of a rig: where it sits, and where its pixels look.
struct Eye {
  int width_px = 0;
  int height_px = 0;
  Isometry T_body_eye = Isometry::Identity();
  float pixel_angle_x = 0;  ///< width of a pixel in its middle, on the plane at depth 1
  float pixel_angle_y = 0;
  std::vector<float> ray_x;  ///< ray (x, y, 1) of each pixel's centre, row by row
  std::vector<float> ray_y;

  [[nodiscard]] std::size_t pixel(int col, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(width_px) +
           static_cast<std::size_t>(col);
  }
  [[nodiscard]] Eigen::Vector3f ray(std::size_t pixel) const {
    return {ray_x[pixel], ray_y[pixel], 1};
  }
};

/// Fails where the camera's model cannot be inverted inside the image.
[[nodiscard]] Result<Eye> make_eye(const camera::CameraModel& camera, int width_px, int height_px,
                                   const Isometry& T_body_eye);

}  // namespace cairn::simulation
