// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "mapping/frame_bricks.hpp"
#include "mapping/integrator.hpp"
#include "mapping/ray_grid.hpp"
#include "mapping/ray_shortcuts.hpp"

namespace cairn::mapping {

/// Exact ray walking (Amanatides and Woo 1987), less those parts of rays whose voxels other rays
/// are sure to meet (RayShortcuts); the outcome is the same. A voxel that a ray ends in gets a hit,
/// one that rays only pass through a miss. The slow reference.
class RayIntegrator : public Integrator {
 public:
  explicit RayIntegrator(const RayIntegratorConfig& config) : config_{config} {}

  [[nodiscard]] Result<Integration> integrate(const stereo::DisparityImage& image,
                                              const Isometry& T_map_camera, VoxelMap& map) override;

 private:
  void cast_rays(const stereo::DisparityImage& image, const Isometry& T_map_camera,
                 const VoxelMap& map, Integration& counts);
  void apply(VoxelMap& map, Integration& counts) const;

  RayIntegratorConfig config_;
  RayGrid rays_;
  RayShortcuts shortcuts_;
  FrameBricks frame_;
};

}  // namespace cairn::mapping
