// SPDX-License-Identifier: Apache-2.0
#include "mapping/height_range.hpp"

#include <bit>
#include <cstddef>
#include <map>

namespace cairn::mapping {

HeightRange occupied_heights(const VoxelMap& map) {
  std::map<std::int32_t, std::size_t> layers;
  map.grid().for_each([&](BrickIndex index, const EvidenceBrick& brick) {
    for (std::int32_t z = 0; z < kBrickSide; ++z) {
      const int count = std::popcount(brick.occupied.words[static_cast<std::size_t>(z)]);
      if (count > 0) layers[index.z * kBrickSide + z] += static_cast<std::size_t>(count);
    }
  });
  if (layers.empty()) return {};
  const std::size_t trim = map.occupied_voxels() / 100;
  HeightRange range{layers.begin()->first, layers.rbegin()->first};
  std::size_t below = 0;
  for (const auto& [z, count] : layers) {
    if (below <= trim) range.min_z = z;
    if (below < map.occupied_voxels() - trim) range.max_z = z;
    below += count;
  }
  return range;
}

}  // namespace cairn::mapping
