// SPDX-License-Identifier: Apache-2.0
#include "mapping/ray_grid.hpp"

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
  const double fb_px_m = camera.f_px * camera.baseline_m;
  const double min_squared_m2 = config.min_range_m * config.min_range_m;
  const double max_squared_m2 = config.max_range_m * config.max_range_m;
  for (int row = 0; row < image.rows(); ++row) {
    const std::uint16_t* const disparity = image.disparity_16ths[row];
    const std::uint8_t* const code = image.code[row];
    double* const end_m = end_depth_m[row];
    std::uint8_t* const hit = is_hit[row];
    const double y = (row * image.step_px - camera.cy_px) / camera.f_px;
    for (int col = 0; col < image.cols(); ++col) {
      end_m[col] = 0;
      hit[col] = 0;
      if (disparity[col] == 0 || code[col] < config.min_confidence) continue;
      const double x = (col * image.step_px - camera.cx_px) / camera.f_px;
      const double slant_squared = x * x + y * y + 1;
      const double shift_px = disparity[col] / 16.0 + camera.doffs_px;
      const double depth_m =
          shift_px > 0 ? fb_px_m / shift_px : std::numeric_limits<double>::infinity();
      const double range_squared_m2 = depth_m * depth_m * slant_squared;
      if (range_squared_m2 < min_squared_m2) continue;
      hit[col] = range_squared_m2 <= max_squared_m2 ? 1 : 0;
      end_m[col] = hit[col] != 0 ? depth_m : config.max_range_m / std::sqrt(slant_squared);
    }
  }
}

}  // namespace cairn::mapping
