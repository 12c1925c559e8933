// SPDX-License-Identifier: Apache-2.0
#include "mapping/ray_integrator.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>

#include "mapping/ray_walker.hpp"

namespace cairn::mapping {
namespace {

Result<void> check(const stereo::DisparityImage& image, const Isometry& T_map_camera,
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

}  // namespace

Result<Integration> RayIntegrator::integrate(const stereo::DisparityImage& image,
                                             const Isometry& T_map_camera, VoxelMap& map) {
  const auto checked = check(image, T_map_camera, map, config_.max_range_m);
  if (!checked) return tl::make_unexpected(checked.error());
  Integration counts;
  frame_.clear();
  lay_out_rays(image);
  cast_rays(image, T_map_camera, map, counts);
  apply(map, counts);
  return counts;
}

void RayIntegrator::lay_out_rays(const stereo::DisparityImage& image) {
  const stereo::RectifiedCamera& camera = image.camera;
  rays_.f_px = camera.f_px / image.step_px;
  rays_.cx_px = camera.cx_px / image.step_px;
  rays_.cy_px = camera.cy_px / image.step_px;
  rays_.end_depth_m.create(image.rows(), image.cols());
  is_hit_.create(image.rows(), image.cols());
  for (int row = 0; row < image.rows(); ++row) {
    const double y = (row * image.step_px - camera.cy_px) / camera.f_px;
    for (int col = 0; col < image.cols(); ++col) {
      double& end_depth_m = rays_.end_depth_m(row, col);
      end_depth_m = 0;
      if (!image.valid(row, col) || image.code(row, col) < config_.min_confidence) continue;
      const double x = (col * image.step_px - camera.cx_px) / camera.f_px;
      const double shift_px = image.disparity_px(row, col) + camera.doffs_px;
      const double slant = std::sqrt(x * x + y * y + 1);
      const double range_m = shift_px > 0 ? camera.f_px * camera.baseline_m / shift_px * slant
                                          : std::numeric_limits<double>::infinity();
      if (range_m < config_.min_range_m) continue;
      end_depth_m = std::min(range_m, config_.max_range_m) / slant;
      is_hit_(row, col) = range_m <= config_.max_range_m ? 1 : 0;
    }
  }
}

void RayIntegrator::cast_rays(const stereo::DisparityImage& image, const Isometry& T_map_camera,
                              const VoxelMap& map, Integration& counts) {
  const stereo::RectifiedCamera& camera = image.camera;
  const double voxels_per_m = 1.0 / map.resolution_m();
  const Eigen::Vector3d origin_m = T_map_camera.translation();
  RayWalker walker{frame_, origin_m * voxels_per_m, map.voxel_at(origin_m)};
  shortcuts_.find(rays_, map.resolution_m());
  const double spared_from_m = RayShortcuts::kFromVoxels * map.resolution_m();
  for (int row = 0; row < rays_.end_depth_m.rows; ++row) {
    const double y = (row * image.step_px - camera.cy_px) / camera.f_px;
    for (int col = 0; col < rays_.end_depth_m.cols; ++col) {
      const double depth_m = rays_.end_depth_m(row, col);
      if (depth_m == 0) continue;
      const double x = (col * image.step_px - camera.cx_px) / camera.f_px;
      const Eigen::Vector3d end_m =
          T_map_camera * Eigen::Vector3d{x * depth_m, y * depth_m, depth_m};
      const VoxelIndex end = map.voxel_at(end_m);
      const RayWalker::Part spared{spared_from_m / depth_m, shortcuts_.until_m(row, col) / depth_m};
      const std::uint32_t last = walker.walk(end_m * voxels_per_m, end, spared);
      const bool is_hit = is_hit_(row, col) != 0;
      if (is_hit) frame_[last].hits.set(index_in_brick(end));
      ++counts.rays;
      counts.hits += is_hit ? 1 : 0;
    }
  }
}

void RayIntegrator::apply(VoxelMap& map, Integration& counts) const {
  for (const FrameBrick& brick : frame_.all()) {
    const VoxelMask misses = brick.misses.mask();
    VoxelMask touched = misses;
    for (std::size_t z = 0; z < kBrickSide; ++z) touched.words[z] |= brick.hits.words[z];
    if (!touched.any()) continue;
    counts.voxels += static_cast<std::size_t>(touched.count());
    if (map.add_evidence(brick.index, brick.hits, misses,
                         static_cast<std::uint8_t>(config_.hit_evidence),
                         static_cast<std::uint8_t>(config_.miss_evidence))) {
      counts.changed.push_back(brick.index);
    }
  }
  std::sort(counts.changed.begin(), counts.changed.end());
}

}  // namespace cairn::mapping
