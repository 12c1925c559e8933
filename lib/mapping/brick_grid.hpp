// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "mapping/grid_index.hpp"

namespace cairn::mapping {

/// Bricks of any kind by their index: tiles in an open-addressed hash, each with a table of its
/// bricks. References to bricks stay good for the life of the grid. What leaves it is sorted, so it
/// does not tell the order of insertion. Reading from several threads is safe while nobody adds.
template <class Brick>
class BrickGrid {
 public:
  BrickGrid() : table_(kFirstTableSize, kNone) {}

  [[nodiscard]] const Brick* find(BrickIndex index) const {
    const Tile* tile = find_tile(tile_of(index));
    return tile == nullptr ? nullptr : in_tile(*tile, index);
  }
  [[nodiscard]] Brick* find(BrickIndex index) {
    return const_cast<Brick*>(std::as_const(*this).find(index));
  }

  /// The brick, made by value-initialisation if there is none. `index` must be within kBrickLimit.
  [[nodiscard]] Brick& find_or_add(BrickIndex index) {
    Tile& tile = find_or_add_tile(tile_of(index));
    std::uint32_t& slot = tile.slots[static_cast<std::size_t>(index_in_tile(index))];
    if (slot == kNone) {
      slot = new_brick();
      ++tile.brick_count;
    }
    return brick(slot);
  }

  [[nodiscard]] std::size_t brick_count() const { return brick_count_; }
  [[nodiscard]] std::size_t tile_count() const { return tiles_.size(); }

  /// Memory held.
  [[nodiscard]] std::size_t bytes() const {
    return chunks_.size() * kChunkBricks * sizeof(Brick) + tiles_.size() * sizeof(Tile) +
           table_.capacity() * sizeof(std::uint32_t);
  }

  /// All tiles that hold a brick, sorted.
  [[nodiscard]] std::vector<TileIndex> tiles() const {
    std::vector<TileIndex> sorted;
    sorted.reserve(tiles_.size());
    for (const auto& tile : tiles_) sorted.push_back(tile->index);
    std::sort(sorted.begin(), sorted.end());
    return sorted;
  }

  [[nodiscard]] std::size_t bricks_in(TileIndex index) const {
    const Tile* tile = find_tile(index);
    return tile == nullptr ? 0 : tile->brick_count;
  }

  /// Calls visit(BrickIndex, const Brick&) for the bricks of a tile in the order of index_in_tile.
  template <class Visit>
  void for_each_in_tile(TileIndex index, Visit&& visit) const {
    const Tile* tile = find_tile(index);
    if (tile == nullptr) return;
    for (int i = 0; i < kTileBricks; ++i) {
      const std::uint32_t slot = tile->slots[static_cast<std::size_t>(i)];
      if (slot != kNone) visit(brick_in(index, i), brick(slot));
    }
  }

  /// Calls visit(BrickIndex, const Brick&) for every brick, sorted by tile and then by
  /// index_in_tile.
  template <class Visit>
  void for_each(Visit&& visit) const {
    for (const TileIndex tile : tiles()) for_each_in_tile(tile, visit);
  }

  /// Finds bricks near one another without a hash look-up each; good until the grid next changes.
  class Cursor {
   public:
    explicit Cursor(const BrickGrid& grid) : grid_{grid} {}
    [[nodiscard]] const Brick* find(BrickIndex index) {
      const TileIndex wanted = tile_of(index);
      if (!valid_ || wanted != at_) {
        tile_ = grid_.find_tile(wanted);
        at_ = wanted;
        valid_ = true;
      }
      return tile_ == nullptr ? nullptr : grid_.in_tile(*tile_, index);
    }

   private:
    const BrickGrid& grid_;
    const typename BrickGrid::Tile* tile_ = nullptr;
    TileIndex at_;
    bool valid_ = false;
  };

 private:
  static constexpr std::uint32_t kNone = 0xffffffff;
  static constexpr std::size_t kChunkBricks = 64;
  static constexpr std::size_t kFirstTableSize = 64;

  struct Tile {
    explicit Tile(TileIndex i) : index{i} { slots.fill(kNone); }
    TileIndex index;
    std::size_t brick_count = 0;
    std::array<std::uint32_t, kTileBricks> slots;
  };

  [[nodiscard]] Brick& brick(std::uint32_t slot) {
    return chunks_[slot / kChunkBricks][slot % kChunkBricks];
  }
  [[nodiscard]] const Brick& brick(std::uint32_t slot) const {
    return chunks_[slot / kChunkBricks][slot % kChunkBricks];
  }

  [[nodiscard]] const Brick* in_tile(const Tile& tile, BrickIndex index) const {
    const std::uint32_t slot = tile.slots[static_cast<std::size_t>(index_in_tile(index))];
    return slot == kNone ? nullptr : &brick(slot);
  }

  [[nodiscard]] std::uint32_t new_brick() {
    if (brick_count_ % kChunkBricks == 0) {
      chunks_.push_back(std::make_unique<Brick[]>(kChunkBricks));
    }
    return static_cast<std::uint32_t>(brick_count_++);
  }

  /// Where in the table a tile is or would go.
  [[nodiscard]] std::size_t place(TileIndex index) const {
    constexpr std::uint64_t kGoldenRatio = 0x9e3779b97f4a7c15ULL;
    const std::size_t last = table_.size() - 1;
    std::size_t at = (packed(index) * kGoldenRatio) >> (64 - std::bit_width(last));
    while (table_[at] != kNone && tiles_[table_[at]]->index != index) at = (at + 1) & last;
    return at;
  }

  [[nodiscard]] const Tile* find_tile(TileIndex index) const {
    const std::uint32_t slot = table_[place(index)];
    return slot == kNone ? nullptr : tiles_[slot].get();
  }

  [[nodiscard]] Tile& find_or_add_tile(TileIndex index) {
    std::size_t at = place(index);
    if (table_[at] == kNone) {
      if (2 * (tiles_.size() + 1) > table_.size()) {
        grow_table();
        at = place(index);
      }
      table_[at] = static_cast<std::uint32_t>(tiles_.size());
      tiles_.push_back(std::make_unique<Tile>(index));
    }
    return *tiles_[table_[at]];
  }

  void grow_table() {
    table_.assign(table_.size() * 2, kNone);
    for (std::size_t i = 0; i < tiles_.size(); ++i) {
      table_[place(tiles_[i]->index)] = static_cast<std::uint32_t>(i);
    }
  }

  std::vector<std::uint32_t> table_;
  std::vector<std::unique_ptr<Tile>> tiles_;
  std::vector<std::unique_ptr<Brick[]>> chunks_;
  std::size_t brick_count_ = 0;
};

}  // namespace cairn::mapping
