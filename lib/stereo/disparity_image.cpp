// SPDX-License-Identifier: Apache-2.0
#include "stereo/disparity_image.hpp"

#include <limits>

namespace cairn::stereo {

double DisparityImage::depth_m(int row, int col) const {
  const double offset_px = disparity_px(row, col) + camera.doffs_px;
  if (!(offset_px > 0)) return std::numeric_limits<double>::infinity();
  return camera.f_px * camera.baseline_m / offset_px;
}

Eigen::Vector3d DisparityImage::point_camera(int row, int col) const {
  const double z_m = depth_m(row, col);
  return {(col * step_px - camera.cx_px) * z_m / camera.f_px,
          (row * step_px - camera.cy_px) * z_m / camera.f_px, z_m};
}

}  // namespace cairn::stereo
