// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "core/geometry.hpp"
#include "mapping/frame_bricks.hpp"
#include "mapping/grid_index.hpp"

namespace cairn::mapping {

/// Marks what the rays of one camera position pass through. Every voxel that the ray's interior
/// meets is marked, and no other; this is the set that Amanatides and Woo (1987) visit, taken layer
/// by layer across the ray's longest axis. Crossings nearer together than about 1e-11 voxels may be
/// taken in either order.
class RayWalker {
 public:
  /// `origin_voxels` is a point of voxel `origin`, in voxel units.
  RayWalker(FrameBricks& frame, const Eigen::Vector3d& origin_voxels, VoxelIndex origin)
      : frame_{frame},
        origin_voxels_{origin_voxels},
        origin_{origin},
        first_brick_{frame.find_or_add(brick_of(origin))} {}

  /// A part of a ray, as shares of its length.
  struct Part {
    double from = 0;
    double to = 0;
  };

  /// Marks misses from the origin up to and with voxel `end`; `end_voxels` is a point of `end`, in
  /// voxel units. Voxels that it meets in `spared` alone may be left out. Gives the brick of `end`.
  std::uint32_t walk(const Eigen::Vector3d& end_voxels, VoxelIndex end, const Part& spared);

 private:
  template <int kAxis>
  std::uint32_t walk_along(const Eigen::Vector3d& end_voxels, std::int32_t planes,
                           const Part& spared);

  FrameBricks& frame_;
  Eigen::Vector3d origin_voxels_;
  VoxelIndex origin_;
  std::uint32_t first_brick_;
};

}  // namespace cairn::mapping
