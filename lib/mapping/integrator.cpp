// SPDX-License-Identifier: Apache-2.0
#include "mapping/integrator.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

namespace cairn::mapping {

Result<void> check_integrable(const stereo::DisparityImage& image, const Isometry& T_map_camera,
                              const VoxelMap& map, double max_range_m) {
  const stereo::RectifiedCamera& camera = image.camera;
  if (image.code.size() != image.disparity_16ths.size()) {
    return fail("disparity image: code plane and disparity plane differ in size");
  }
  const std::array<double, 5> numbers{camera.f_px, camera.cx_px, camera.cy_px, camera.doffs_px,
                                      camera.baseline_m};
  if (!std::all_of(numbers.begin(), numbers.end(), [](double n) { return std::isfinite(n); }) ||
      camera.f_px <= 0 || camera.baseline_m <= 0 || image.step_px < 1) {
    return fail(
        "disparity image: camera needs finite numbers, f_px, baseline_m and step_px over 0");
  }
  if (!T_map_camera.matrix().allFinite()) return fail("map pose: not finite");
  const double limit_m = (kVoxelLimit - 2) * map.resolution_m() - max_range_m;
  if (T_map_camera.translation().cwiseAbs().maxCoeff() > limit_m) {
    return fail("map pose: " + std::to_string(T_map_camera.translation().cwiseAbs().maxCoeff()) +
                " m from the origin, the map ends at " + std::to_string(limit_m) + " m");
  }
  return {};
}

}  // namespace cairn::mapping
