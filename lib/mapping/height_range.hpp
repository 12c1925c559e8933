// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "mapping/voxel_map.hpp"

namespace cairn::mapping {

/// Layers of voxels [min_z, max_z], in voxels.
struct HeightRange {
  std::int32_t min_z = 0;
  std::int32_t max_z = 0;

  /// 0 at the lowest, 1 at the highest.
  [[nodiscard]] double share(std::int32_t z) const {
    return max_z > min_z ? static_cast<double>(z - min_z) / (max_z - min_z) : 0.5;
  }
};

/// The layers that hold the occupied voxels, but for the lowest and the highest 1 %.
[[nodiscard]] HeightRange occupied_heights(const VoxelMap& map);

}  // namespace cairn::mapping
