// SPDX-License-Identifier: Apache-2.0
#include "mapping/ray_integrator.hpp"

#include <algorithm>
#include <cstdint>

#include "mapping/ray_walker.hpp"

namespace cairn::mapping {

Result<Integration> RayIntegrator::integrate(const stereo::DisparityImage& image,
                                             const Isometry& T_map_camera, VoxelMap& map) {
  const auto checked = check_integrable(image, T_map_camera, map, config_.max_range_m);
  if (!checked) return tl::make_unexpected(checked.error());
  Integration counts;
  frame_.clear();
  rays_.lay_out(image, config_);
  cast_rays(image, T_map_camera, map, counts);
  apply(map, counts);
  return counts;
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
      const bool is_hit = rays_.is_hit(row, col) != 0;
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
