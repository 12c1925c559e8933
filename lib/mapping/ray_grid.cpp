// SPDX-License-Identifier: Apache-2.0
#include "mapping/ray_grid.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace cairn::mapping {

void RayGrid::lay_out(const stereo::DisparityImage& image, const RayIntegratorConfig& config) {
  const stereo::RectifiedCamera& camera = image.camera;
  f_px = camera.f_px / image.step_px;
  cx_px = camera.cx_px / image.step_px;
  cy_px = camera.cy_px / image.step_px;
  end_depth_m.create(image.rows(), image.cols());
  is_hit.create(image.rows(), image.cols());
  for (int row = 0; row < image.rows(); ++row) {
    const double y = (row * image.step_px - camera.cy_px) / camera.f_px;
    for (int col = 0; col < image.cols(); ++col) {
      double& end_m = end_depth_m(row, col);
      end_m = 0;
      is_hit(row, col) = 0;
      if (!image.valid(row, col) || image.code(row, col) < config.min_confidence) continue;
      const double x = (col * image.step_px - camera.cx_px) / camera.f_px;
      const double shift_px = image.disparity_px(row, col) + camera.doffs_px;
      const double slant = std::sqrt(x * x + y * y + 1);
      const double range_m = shift_px > 0 ? camera.f_px * camera.baseline_m / shift_px * slant
                                          : std::numeric_limits<double>::infinity();
      if (range_m < config.min_range_m) continue;
      end_m = std::min(range_m, config.max_range_m) / slant;
      is_hit(row, col) = range_m <= config.max_range_m ? 1 : 0;
    }
  }
}

}  // namespace cairn::mapping
