// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>

#include "core/geometry.hpp"
#include "mapping/integrator.hpp"
#include "stereo/disparity_image.hpp"

namespace cairn::mapping::testing {

/// A camera of f * baseline = 80 px m, so that a depth of 80 / n metres is exact for whole n.
inline stereo::RectifiedCamera small_camera(int width_px, int height_px) {
  stereo::RectifiedCamera camera;
  camera.f_px = width_px;
  camera.cx_px = 0.5 * width_px;
  camera.cy_px = 0.5 * height_px;
  camera.baseline_m = 80.0 / width_px;
  camera.width_px = width_px;
  camera.height_px = height_px;
  return camera;
}

/// depth(row, col) [m] gives each pixel's depth along the optical axis; 0 is no answer.
template <class Depth>
stereo::DisparityImage image_of(const stereo::RectifiedCamera& camera, int step_px, Depth&& depth) {
  stereo::DisparityImage image;
  image.camera = camera;
  image.step_px = step_px;
  const int rows = camera.height_px / step_px;
  const int cols = camera.width_px / step_px;
  image.disparity_16ths.create(rows, cols);
  image.code.create(rows, cols);
  for (int row = 0; row < rows; ++row) {
    for (int col = 0; col < cols; ++col) {
      const double depth_m = depth(row, col);
      image.disparity_16ths(row, col) =
          depth_m > 0 ? static_cast<std::uint16_t>(
                            std::lround(16 * camera.f_px * camera.baseline_m / depth_m))
                      : std::uint16_t{0};
      image.code(row, col) = depth_m > 0 ? 3 : 0;
    }
  }
  return image;
}

/// A camera that looks forward from a body here, turned so.
inline Isometry pose(const Eigen::Vector3d& position_m, double roll, double pitch, double yaw) {
  Isometry T = Isometry::Identity();
  T.linear() = rotation_from_rpy(roll, pitch, yaw) * R_body_camera_forward();
  T.translation() = position_m;
  return T;
}

inline RayIntegratorConfig to_range(double max_range_m) {
  RayIntegratorConfig config;
  config.max_range_m = max_range_m;
  return config;
}

}  // namespace cairn::mapping::testing
