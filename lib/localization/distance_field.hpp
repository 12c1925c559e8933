// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <span>
#include <vector>

#include "core/geometry.hpp"
#include "mapping/brick_grid.hpp"
#include "mapping/map_replica.hpp"

namespace cairn::localization {

/// A cell of the field; cell (x, y, z) fills [x, x+1) * cell_m along each axis of the map frame.
using CellIndex = mapping::VoxelIndex;

/// How far it is to the nearest occupied cell, for every cell of the map, and which cells are
/// unknown. A cell is some voxels a side (about 4 cm); it is occupied if one of its voxels is, and
/// known if one of its voxels is.
///
/// What a cell is, is up to date after take(). Distances are so once work() has caught up: it is
/// called once a frame with a fixed amount, so that no frame takes long and none depends on the
/// machine's speed.
class DistanceField {
 public:
  /// Beyond this many cells, all is equally far.
  static constexpr int kReach_cells = 15;
  /// Distances are told in so many steps to a cell.
  static constexpr int kStepsPerCell = 8;
  static constexpr std::uint8_t kFar = kReach_cells * kStepsPerCell;
  /// Set where the cell is unknown.
  static constexpr std::uint8_t kUnknownBit = 0x80;

  /// Must be told all of a copy's changes, in order.
  void take(const mapping::MapReplica& map, const mapping::MapReplica::Changes& changes);

  /// Recomputes at most `at_most` of the blocks of 8 x 8 x 8 cells whose distances are out of date:
  /// first those within half a block's side of `first_m`, then in the order in which they became
  /// so. Gives how many.
  std::size_t work(std::span<const Eigen::Vector3d> first_m, std::size_t at_most);

  /// Blocks that are out of date.
  [[nodiscard]] std::size_t behind() const { return behind_; }
  /// Occupied cells.
  [[nodiscard]] std::size_t occupied_cells() const { return occupied_cells_; }
  /// Counts up when a cell's state changed.
  [[nodiscard]] std::uint64_t version() const { return version_; }

  /// 0 before the first map.
  [[nodiscard]] double cell_m() const { return cell_m_; }
  [[nodiscard]] int voxels_per_cell() const { return voxels_per_cell_; }
  [[nodiscard]] CellIndex cell_at(const Eigen::Vector3d& point_m) const;
  [[nodiscard]] Eigen::Vector3d centre_of(CellIndex cell) const;

  /// Distance between the middles of this cell and the nearest occupied one, in 1 / kStepsPerCell
  /// of a cell, rounded, at most kFar; with kUnknownBit.
  [[nodiscard]] std::uint8_t at(CellIndex cell) const { return Cursor{*this}.at(cell); }
  [[nodiscard]] bool occupied(CellIndex cell) const { return Cursor{*this}.occupied(cell); }

  /// 8 x 8 x 8 cells in the order of index_in_brick.
  struct Block {
    Block() { distance.fill(kFar | kUnknownBit); }
    std::array<std::uint8_t, mapping::kBrickVoxels> distance;
    mapping::VoxelMask occupied;
    mapping::VoxelMask known;
    bool behind = false;
  };
  using Grid = mapping::BrickGrid<Block>;
  [[nodiscard]] const Grid& grid() const { return grid_; }

  /// Looks up cells that lie near one another; good until the field next changes.
  class Cursor {
   public:
    explicit Cursor(const DistanceField& field) : blocks_{field.grid_} {}
    [[nodiscard]] std::uint8_t at(CellIndex cell) {
      const Block* block = blocks_.find(mapping::brick_of(cell));
      return block == nullptr
                 ? static_cast<std::uint8_t>(kFar | kUnknownBit)
                 : block->distance[static_cast<std::size_t>(mapping::index_in_brick(cell))];
    }
    [[nodiscard]] bool occupied(CellIndex cell) {
      const Block* block = blocks_.find(mapping::brick_of(cell));
      return block != nullptr && block->occupied.test(mapping::index_in_brick(cell));
    }

   private:
    Grid::Cursor blocks_;
  };

 private:
  void start_over(double resolution_m);
  void take_brick(const mapping::MapReplica& map, mapping::BrickIndex brick);
  void mark_around(CellIndex low, CellIndex high);
  void recompute(mapping::BrickIndex index, Block& block) const;

  Grid grid_;
  double resolution_m_ = 0;
  double cell_m_ = 0;
  int voxels_per_cell_ = 1;
  std::deque<mapping::BrickIndex> queue_;
  std::size_t behind_ = 0;
  std::size_t occupied_cells_ = 0;
  std::uint64_t version_ = 0;
};

}  // namespace cairn::localization
