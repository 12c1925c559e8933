// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stereo/disparity_image.hpp"

namespace cairn::stereo {

/// Standard deviation of a depth [m] that comes from a disparity with standard deviation
/// `disparity_sigma_px` [full-size px], to first order: sigma_z = z^2 sigma_d / (f b).
[[nodiscard]] constexpr double depth_sigma_m(double f_px, double baseline_m, double depth_m,
                                             double disparity_sigma_px) {
  return depth_m * depth_m * disparity_sigma_px / (f_px * baseline_m);
}

[[nodiscard]] inline double depth_sigma_m(const RectifiedCamera& camera, double depth_m,
                                          double disparity_sigma_px) {
  return depth_sigma_m(camera.f_px, camera.baseline_m, depth_m, disparity_sigma_px);
}

}  // namespace cairn::stereo
