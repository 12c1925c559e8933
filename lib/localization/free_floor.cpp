// SPDX-License-Identifier: Apache-2.0
#include "localization/free_floor.hpp"

namespace cairn::localization {

FreeFloor::FreeFloor(const DistanceField& field, double z_m, double clearance_m)
    : cell_m_{field.cell_m()} {
  if (cell_m_ <= 0) return;
  const std::int32_t layer = field.cell_at({0, 0, z_m}).z;
  const double least_steps = clearance_m / cell_m_ * DistanceField::kStepsPerCell;
  field.grid().for_each([&](mapping::BrickIndex index, const DistanceField::Block& block) {
    if (index.z != layer >> 3) return;
    const int first = (layer & 7) << 6;
    for (int place = first; place < first + 64; ++place) {
      const std::uint8_t distance = block.distance[static_cast<std::size_t>(place)];
      if ((distance & DistanceField::kUnknownBit) != 0 || distance < least_steps) continue;
      const mapping::VoxelIndex cell = mapping::voxel_in(index, place);
      cells_.push_back({cell.x, cell.y});
    }
  });
}

Eigen::Vector2d FreeFloor::sample_m(RandomSource& random) const {
  const Cell& cell = cells_[random.below(cells_.size())];
  return {(cell.x + random.uniform()) * cell_m_, (cell.y + random.uniform()) * cell_m_};
}

}  // namespace cairn::localization
