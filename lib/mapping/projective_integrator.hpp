// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "mapping/brick_table.hpp"
#include "mapping/depth_pyramid.hpp"
#include "mapping/free_space.hpp"
#include "mapping/integrator.hpp"
#include "mapping/ray_grid.hpp"

namespace cairn::mapping {

/// Projective carving: instead of walking rays through the map, the map's cubes are held against
/// the depth image, the largest first (after Steinbruecker, Sturm and Cremers 2014, who update an
/// octree so; the pyramid of nearest and farthest depth is Greene, Kass and Miller 1993). A cube
/// that lies wholly before all that is seen there is free in one step, one behind it all or out of
/// the image is passed over, and only the bricks between are worked voxel by voxel.
///
/// A voxel is free in a frame if it lies wholly before the nearest of the rays that its brick's
/// voxels are as wide as: those of one pixel where they are narrower than two, else of the cell of
/// 2^n pixels (n as large as a voxel's width allows) that its centre appears in; with one more
/// pixel around. Without a ray there, nothing is said. A voxel that a ray ends in gets a hit, as in
/// RayIntegrator.
///
/// Differs from exact ray walking on purpose: voxels between two rays that both pass are free; a
/// voxel that one ray passes and a near neighbour ends before is not, so surfaces at grazing angles
/// and edges of near things are not eaten.
class ProjectiveIntegrator : public Integrator {
 public:
  explicit ProjectiveIntegrator(const RayIntegratorConfig& config) : config_{config} {}

  [[nodiscard]] Result<Integration> integrate(const stereo::DisparityImage& image,
                                              const Isometry& T_map_camera, VoxelMap& map) override;

 private:
  struct HitBrick {
    BrickIndex index;
    VoxelMask hits;
    bool added = false;
  };

  void mark_hits(const Isometry& T_map_camera, const VoxelMap& map, Integration& counts);
  void add_all(VoxelMap& map, Integration& counts);
  void add(BrickIndex brick, const VoxelMask& misses, VoxelMap& map, Integration& counts);

  RayIntegratorConfig config_;
  RayGrid rays_;
  DepthPyramid pyramid_;
  BrickTable<HitBrick> hits_;
  FreeSpace free_;
};

}  // namespace cairn::mapping
