// SPDX-License-Identifier: Apache-2.0
#include "localization/distance_field.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace cairn::localization {
namespace {

using mapping::BrickIndex;
using mapping::kBrickSide;
using mapping::VoxelMask;

constexpr double kLargestCell_m = 0.045;
constexpr int kReach = DistanceField::kReach_cells;
constexpr std::int16_t kNothing = 1000;  // more than any square within reach

/// What is needed around a block, in cells from its corner: two blocks each way.
constexpr int kMargin = 16;
constexpr int kSpan = kMargin + kBrickSide + kMargin;
constexpr int kBlocksAcross = kSpan / kBrickSide;
static_assert(kReach < kMargin);

/// Squared distance in cells to steps.
const std::array<std::uint8_t, kReach * kReach + 1>& steps_by_square() {
  static const auto table = [] {
    std::array<std::uint8_t, kReach * kReach + 1> steps{};
    for (std::size_t square = 0; square < steps.size(); ++square) {
      steps[square] = static_cast<std::uint8_t>(
          std::lround(DistanceField::kStepsPerCell * std::sqrt(static_cast<double>(square))));
    }
    return steps;
  }();
  return table;
}

int cell_side_in_voxels(double resolution_m) {
  int voxels = 1;
  while (voxels < kBrickSide && 2 * voxels * resolution_m <= kLargestCell_m) voxels *= 2;
  return voxels;
}

/// The squared distance transform around one block, one axis after the other (Saito and Toriwaki
/// 1994), for the block's own cells.
class BlockTransform {
 public:
  /// `around`: occupied cells of the 5 x 5 x 5 blocks with the wanted one in the middle, x fastest;
  /// null where there are none.
  explicit BlockTransform(
      const std::array<const VoxelMask*, kBlocksAcross * kBlocksAcross * kBlocksAcross>& around) {
    for (int bz = 0; bz < kBlocksAcross; ++bz) {
      for (int by = 0; by < kBlocksAcross; ++by) {
        along_x(&around[static_cast<std::size_t>((bz * kBlocksAcross + by) * kBlocksAcross)], bz,
                by);
      }
    }
    for (int z = 1; z < kSpan - 1; ++z) {
      if (any_[static_cast<std::size_t>(z)]) along_y(z);
    }
    squares_.fill(kNothing);
    for (int dz = -kReach; dz <= kReach; ++dz) along_z(dz);
  }

  [[nodiscard]] std::int16_t square(std::size_t cell) const { return squares_[cell]; }

 private:
  using Rows = std::array<std::int16_t, kBrickSide>;

  [[nodiscard]] Rows& row(int z, int y) { return rows_[static_cast<std::size_t>(z * kSpan + y)]; }

  void along_x(const VoxelMask* const* blocks, int bz, int by) {
    for (int z = 0; z < kBrickSide; ++z) {
      std::array<std::uint64_t, kBlocksAcross> words{};
      std::uint64_t all = 0;
      for (std::size_t i = 0; i < words.size(); ++i) {
        if (blocks[i] != nullptr) words[i] = blocks[i]->words[static_cast<std::size_t>(z)];
        all |= words[i];
      }
      any_[static_cast<std::size_t>(bz * kBrickSide + z)] |= all != 0;
      for (int y = 0; y < kBrickSide; ++y) {
        Rows& out = row(bz * kBrickSide + z, by * kBrickSide + y);
        out.fill(kNothing);
        if ((all >> (8 * y) & 0xff) == 0) continue;
        std::uint64_t bits = 0;
        for (std::size_t i = 0; i < words.size(); ++i) {
          bits |= (words[i] >> (8 * y) & 0xff) << (8 * i);
        }
        for (int x = 0; x < kBrickSide; ++x) {
          const int nearest = std::min(std::countl_zero(bits << (63 - kMargin - x)),
                                       std::countr_zero(bits >> (kMargin + x)));
          if (nearest <= kReach)
            out[static_cast<std::size_t>(x)] = static_cast<std::int16_t>(nearest * nearest);
        }
      }
    }
  }

  void along_y(int z) {
    std::int16_t* const out = planes_[static_cast<std::size_t>(z)].data();
    std::fill(out, out + kBrickSide * kBrickSide, kNothing);
    for (int dy = -kReach; dy <= kReach; ++dy) {
      const std::int16_t* const in = row(z, kMargin + dy).data();
      const auto square = static_cast<std::int16_t>(dy * dy);
      for (int i = 0; i < kBrickSide * kBrickSide; ++i) {
        const auto sum = static_cast<std::int16_t>(in[i] + square);
        out[i] = sum < out[i] ? sum : out[i];
      }
    }
  }

  void along_z(int dz) {
    const auto square = static_cast<std::int16_t>(dz * dz);
    for (int z = 0; z < kBrickSide; ++z) {
      const auto from = static_cast<std::size_t>(kMargin + z + dz);
      if (!any_[from]) continue;
      const std::int16_t* const in = planes_[from].data();
      std::int16_t* const out = squares_.data() + z * kBrickSide * kBrickSide;
      for (int i = 0; i < kBrickSide * kBrickSide; ++i) {
        const auto sum = static_cast<std::int16_t>(in[i] + square);
        out[i] = sum < out[i] ? sum : out[i];
      }
    }
  }

  std::array<Rows, kSpan * kSpan> rows_;
  std::array<std::array<std::int16_t, kBrickSide * kBrickSide>, kSpan> planes_;
  std::array<std::int16_t, mapping::kBrickVoxels> squares_;
  std::array<bool, kSpan> any_{};
};

}  // namespace

void DistanceField::take(const mapping::MapReplica& map,
                         const mapping::MapReplica::Changes& changes) {
  if (changes.started_over || map.resolution_m() != resolution_m_) start_over(map.resolution_m());
  for (const BrickIndex brick : changes.bricks) take_brick(map, brick);
}

void DistanceField::start_over(double resolution_m) {
  grid_ = Grid{};
  queue_.clear();
  behind_ = 0;
  occupied_cells_ = 0;
  ++version_;
  resolution_m_ = resolution_m;
  voxels_per_cell_ = cell_side_in_voxels(resolution_m);
  cell_m_ = resolution_m * voxels_per_cell_;
}

void DistanceField::take_brick(const mapping::MapReplica& map, BrickIndex brick) {
  const mapping::ClassBrick* voxels = map.grid().find(brick);
  if (voxels == nullptr) return;
  const int side = voxels_per_cell_;
  const int cells = kBrickSide / side;
  const CellIndex corner{brick.x * cells, brick.y * cells, brick.z * cells};
  Block& block = grid_.find_or_add(mapping::brick_of(corner));
  std::uint64_t square = 0;  // a cell's voxels in a layer
  for (int y = 0; y < side; ++y) square |= ((std::uint64_t{1} << side) - 1) << (8 * y);
  CellIndex low{cells, cells, cells};
  CellIndex high{-1, -1, -1};
  for (int i = 0; i < cells * cells * cells; ++i) {
    const CellIndex in{i % cells, i / cells % cells, i / (cells * cells)};
    const int shift = in.x * side + 8 * in.y * side;
    std::uint64_t known = 0;
    std::uint64_t occupied = 0;
    for (int z = in.z * side; z < (in.z + 1) * side; ++z) {
      known |= voxels->known.words[static_cast<std::size_t>(z)] >> shift & square;
      occupied |= voxels->occupied.words[static_cast<std::size_t>(z)] >> shift & square;
    }
    const int place = mapping::index_in_brick({corner.x + in.x, corner.y + in.y, corner.z + in.z});
    const std::uint64_t bit = std::uint64_t{1} << (place & 63);
    const auto word = static_cast<std::size_t>(place >> 6);
    std::uint8_t& distance = block.distance[static_cast<std::size_t>(place)];
    if (known != 0) {
      block.known.words[word] |= bit;
      distance = static_cast<std::uint8_t>(distance & ~kUnknownBit);
    } else {
      block.known.words[word] &= ~bit;
      distance = static_cast<std::uint8_t>(distance | kUnknownBit);
    }
    if (block.occupied.test(place) == (occupied != 0)) continue;
    block.occupied.words[word] ^= bit;
    occupied_cells_ += occupied != 0 ? 1 : static_cast<std::size_t>(-1);
    low = {std::min(low.x, in.x), std::min(low.y, in.y), std::min(low.z, in.z)};
    high = {std::max(high.x, in.x), std::max(high.y, in.y), std::max(high.z, in.z)};
  }
  ++version_;
  if (high.x < 0) return;
  mark_around({corner.x + low.x, corner.y + low.y, corner.z + low.z},
              {corner.x + high.x, corner.y + high.y, corner.z + high.z});
}

void DistanceField::mark_around(CellIndex low, CellIndex high) {
  const BrickIndex first = mapping::brick_of({low.x - kReach, low.y - kReach, low.z - kReach});
  const BrickIndex last = mapping::brick_of({high.x + kReach, high.y + kReach, high.z + kReach});
  for (std::int32_t z = first.z; z <= last.z; ++z) {
    for (std::int32_t y = first.y; y <= last.y; ++y) {
      for (std::int32_t x = first.x; x <= last.x; ++x) {
        if (!mapping::within(BrickIndex{x, y, z}, mapping::kBrickLimit)) continue;
        Block& block = grid_.find_or_add({x, y, z});
        if (block.behind) continue;
        block.behind = true;
        ++behind_;
        queue_.push_back({x, y, z});
      }
    }
  }
}

std::size_t DistanceField::work(std::span<const Eigen::Vector3d> first_m, std::size_t at_most) {
  std::size_t done = 0;
  const auto bring_up = [&](BrickIndex index) {
    Block* block = grid_.find(index);
    if (block == nullptr || !block->behind) return;
    recompute(index, *block);
    block->behind = false;
    --behind_;
    ++done;
  };
  constexpr int kHalf = kBrickSide / 2;
  for (const Eigen::Vector3d& point_m : first_m) {
    if (behind_ == 0) break;
    const CellIndex cell = cell_at(point_m);
    for (int corner = 0; corner < 8 && done < at_most; ++corner) {
      bring_up(mapping::brick_of({cell.x + (corner & 1 ? kHalf : -kHalf),
                                  cell.y + (corner & 2 ? kHalf : -kHalf),
                                  cell.z + (corner & 4 ? kHalf : -kHalf)}));
    }
  }
  while (done < at_most && !queue_.empty()) {
    bring_up(queue_.front());
    queue_.pop_front();
  }
  if (behind_ == 0) queue_.clear();
  return done;
}

void DistanceField::recompute(BrickIndex index, Block& block) const {
  std::array<const VoxelMask*, kBlocksAcross * kBlocksAcross * kBlocksAcross> around{};
  bool any = false;
  Grid::Cursor blocks{grid_};
  for (std::size_t i = 0; i < around.size(); ++i) {
    const auto at = static_cast<std::int32_t>(i);
    const Block* other = blocks.find({index.x + at % kBlocksAcross - 2,
                                      index.y + at / kBlocksAcross % kBlocksAcross - 2,
                                      index.z + at / (kBlocksAcross * kBlocksAcross) - 2});
    if (other == nullptr || !other->occupied.any()) continue;
    around[i] = &other->occupied;
    any = true;
  }
  const auto set = [&](std::size_t cell, std::uint8_t steps) {
    const bool known = block.known.test(static_cast<int>(cell));
    block.distance[cell] = static_cast<std::uint8_t>(steps | (known ? 0 : kUnknownBit));
  };
  if (!any) {
    for (std::size_t cell = 0; cell < block.distance.size(); ++cell) set(cell, kFar);
    return;
  }
  const BlockTransform transform{around};
  const auto& steps = steps_by_square();
  for (std::size_t cell = 0; cell < block.distance.size(); ++cell) {
    const auto square = static_cast<std::size_t>(transform.square(cell));
    set(cell, square < steps.size() ? steps[square] : kFar);
  }
}

CellIndex DistanceField::cell_at(const Eigen::Vector3d& point_m) const {
  const auto along = [this](double metres) {
    constexpr double kMost = 1 << 30;
    const double cells = cell_m_ > 0 ? std::floor(metres / cell_m_) : 0;
    return static_cast<std::int32_t>(std::clamp(cells, -kMost, kMost));
  };
  return {along(point_m.x()), along(point_m.y()), along(point_m.z())};
}

Eigen::Vector3d DistanceField::centre_of(CellIndex cell) const {
  return (Eigen::Vector3d(cell.x, cell.y, cell.z).array() + 0.5) * cell_m_;
}

}  // namespace cairn::localization
