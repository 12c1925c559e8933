// SPDX-License-Identifier: Apache-2.0
#include "mapping/projective_integrator.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace cairn::mapping {

Result<Integration> ProjectiveIntegrator::integrate(const stereo::DisparityImage& image,
                                                    const Isometry& T_map_camera, VoxelMap& map) {
  const auto checked = check_integrable(image, T_map_camera, map, config_.max_range_m);
  if (!checked) return tl::make_unexpected(checked.error());
  Integration counts;
  rays_.lay_out(image, config_);
  mark_hits(T_map_camera, map, counts);
  if (counts.rays == 0) return counts;
  pyramid_.build(rays_);
  FreeSpaceFinder(rays_, pyramid_, T_map_camera, map.resolution_m(), config_.max_range_m)
      .find(free_);
  add_all(map, counts);
  std::sort(counts.changed.begin(), counts.changed.end());
  return counts;
}

void ProjectiveIntegrator::mark_hits(const Isometry& T_map_camera, const VoxelMap& map,
                                     Integration& counts) {
  hits_.clear();
  const Eigen::Vector3d from_m = T_map_camera.translation();
  const Eigen::Matrix3d R = T_map_camera.linear();
  const Eigen::Vector3d per_col = R.col(0) / rays_.f_px;
  BrickIndex brick{kBrickLimit, 0, 0};  // no brick is there
  std::uint32_t place = 0;
  for (int row = 0; row < rays_.end_depth_m.rows; ++row) {
    const double* const end_m = rays_.end_depth_m[row];
    const std::uint8_t* const is_hit = rays_.is_hit[row];
    const Eigen::Vector3d along_row =
        R.col(2) + R.col(1) * ((row - rays_.cy_px) / rays_.f_px) - rays_.cx_px * per_col;
    for (int col = 0; col < rays_.end_depth_m.cols; ++col) {
      if (end_m[col] == 0) continue;
      ++counts.rays;
      if (is_hit[col] == 0) continue;
      ++counts.hits;
      const VoxelIndex end = map.voxel_at(from_m + end_m[col] * (along_row + col * per_col));
      if (brick_of(end) != brick) {
        brick = brick_of(end);
        place = hits_.find_or_add(brick);
      }
      hits_[place].hits.set(index_in_brick(end));
    }
  }
}

void ProjectiveIntegrator::add_all(VoxelMap& map, Integration& counts) {
  const auto miss = static_cast<std::uint8_t>(config_.miss_evidence);
  for (const BrickIndex brick : free_.whole) {
    if (hits_.find(brick) != nullptr) {
      add(brick, VoxelMask::all(), map, counts);
      continue;
    }
    counts.voxels += kBrickVoxels;
    if (map.add_free(brick, miss)) counts.changed.push_back(brick);
  }
  for (const auto& [brick, voxels] : free_.parts) add(brick, voxels, map, counts);
  for (const HitBrick& brick : hits_.all()) {
    if (!brick.added) add(brick.index, {}, map, counts);
  }
}

void ProjectiveIntegrator::add(BrickIndex brick, const VoxelMask& misses, VoxelMap& map,
                               Integration& counts) {
  VoxelMask hits;
  if (HitBrick* const of_brick = hits_.find(brick); of_brick != nullptr) {
    hits = of_brick->hits;
    of_brick->added = true;
  }
  VoxelMask touched = misses;
  for (std::size_t z = 0; z < kBrickSide; ++z) touched.words[z] |= hits.words[z];
  counts.voxels += static_cast<std::size_t>(touched.count());
  if (map.add_evidence(brick, hits, misses, static_cast<std::uint8_t>(config_.hit_evidence),
                       static_cast<std::uint8_t>(config_.miss_evidence))) {
    counts.changed.push_back(brick);
  }
}

}  // namespace cairn::mapping
