// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "mapping/map_replica.hpp"
#include "planning/cell_grid.hpp"

namespace cairn::planning {

/// What the map holds over each cell, as 64 layers around the height 0: layer i is [bottom_m() + i
/// layer_m(), + layer_m()). A voxel belongs to the cell and the layer that its centre lies in.
class VoxelColumns {
 public:
  static constexpr int kLayers = 64;
  static constexpr int kLayersBelow = 24;
  /// Cells farther from the first ones than this are left out [cells].
  static constexpr std::int32_t kMaxSide = 1536;

  struct Column {
    std::uint64_t occupied = 0;  ///< bit i: layer i has an occupied voxel
    std::uint64_t free = 0;      ///< bit i: layer i has a free one
  };

  void clear();

  /// Reads these bricks anew.
  void update(const mapping::MapReplica& map, std::span<const mapping::BrickIndex> bricks);

  [[nodiscard]] const CellBox& box() const { return box_; }
  [[nodiscard]] const Column& column(std::size_t index) const { return columns_[index]; }
  /// Of voxels coarser than 2 cm as high as they are, else 2 cm [m].
  [[nodiscard]] double layer_m() const { return layer_m_; }
  [[nodiscard]] double bottom_m() const { return -kLayersBelow * layer_m_; }

  /// Makes the box hold this square, as far as kMaxSide allows.
  void cover(const Eigen::Vector2d& centre_m, double half_side_m);

 private:
  void update_brick(const mapping::MapReplica::Grid& grid, mapping::BrickIndex brick);
  void read_layers(const mapping::MapReplica::Grid& grid, Cell cell, int first, int last);
  void add_layers(const mapping::ClassBrick& brick, std::int32_t brick_z, std::uint64_t mask,
                  Column& seen) const;
  [[nodiscard]] int layer_of(double z_m) const;
  bool grow_to(Cell low, Cell high);

  double resolution_m_ = 0;
  double layer_m_ = 0.02;
  CellBox box_;
  std::vector<Column> columns_;
};

}  // namespace cairn::planning
