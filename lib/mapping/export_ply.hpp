// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "core/result.hpp"
#include "mapping/voxel_map.hpp"

namespace cairn::mapping {

/// The centres of the occupied voxels as a PLY point cloud (binary little endian: x y z in metres
/// as float, red green blue by height). The same map gives the same bytes.
[[nodiscard]] std::vector<std::uint8_t> encode_ply(const VoxelMap& map);
[[nodiscard]] Result<void> export_ply(const std::filesystem::path& path, const VoxelMap& map);

}  // namespace cairn::mapping
