// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "core/geometry.hpp"
#include "mapping/map_replica.hpp"
#include "mapping/voxel_map.hpp"

namespace cairn::mapping {

struct RaycastHit {
  double distance_m = 0;  ///< to where the ray enters the voxel; 0 if it starts inside
  VoxelIndex voxel;
};

/// The first occupied voxel that a ray meets, by exact walking (Amanatides and Woo 1987); unknown
/// voxels do not stop it. Origin and direction in the map frame; the direction need not be of
/// length 1. Nothing within max_range_m, for numbers that are not finite, for a zero direction, or
/// for a ray that leaves the map's limits.
[[nodiscard]] std::optional<RaycastHit> raycast(const VoxelMap& map,
                                                const Eigen::Vector3d& origin_m,
                                                const Eigen::Vector3d& direction,
                                                double max_range_m);
[[nodiscard]] std::optional<RaycastHit> raycast(const MapReplica& map,
                                                const Eigen::Vector3d& origin_m,
                                                const Eigen::Vector3d& direction,
                                                double max_range_m);

}  // namespace cairn::mapping
