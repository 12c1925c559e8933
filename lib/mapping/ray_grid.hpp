// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>

#include "mapping/integrator.hpp"
#include "stereo/disparity_image.hpp"

namespace cairn::mapping {

/// A grid of rays from one point: ray (row, col) runs along ((col - cx) / f, (row - cy) / f, 1).
struct RayGrid {
  double f_px = 1;  ///< in steps of the grid, as cx_px and cy_px
  double cx_px = 0;
  double cy_px = 0;
  cv::Mat_<double> end_depth_m;   ///< where each ray ends, along the third axis; 0: there is no ray
  cv::Mat_<std::uint8_t> is_hit;  ///< not 0: the ray ends at what was measured, not at max_range_m

  /// One ray for each pixel that may be used.
  void lay_out(const stereo::DisparityImage& image, const RayIntegratorConfig& config);
};

}  // namespace cairn::mapping
