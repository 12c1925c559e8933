// SPDX-License-Identifier: Apache-2.0
#include "planning/voxel_columns.hpp"

#include <algorithm>
#include <cmath>

namespace cairn::planning {
namespace {

using mapping::BrickIndex;
using mapping::kBrickSide;

constexpr double kThinnestLayer_m = 0.02;
constexpr double kRounding_m = 1e-9;
constexpr std::int32_t kGrowth = 32;  // cells; the box grows by this much at least

struct Span {
  std::int32_t first;
  std::int32_t last;
};

/// Voxels whose centres lie in [low_m, low_m + side_m); at least the one around the middle.
Span voxels_in(double low_m, double side_m, double resolution_m) {
  const auto first = static_cast<std::int32_t>(std::ceil(low_m / resolution_m - 0.5 - 1e-9));
  const auto last =
      static_cast<std::int32_t>(std::ceil((low_m + side_m) / resolution_m - 0.5 - 1e-9)) - 1;
  if (last >= first) return {first, last};
  const auto middle = static_cast<std::int32_t>(std::floor((low_m + side_m / 2) / resolution_m));
  return {middle, middle};
}

/// Bits x + 8 y of those voxels of a brick's layer that lie in both spans.
std::uint64_t layer_mask(BrickIndex brick, Span x, Span y) {
  std::uint64_t mask = 0;
  const std::int32_t x0 = brick.x * kBrickSide;
  const std::int32_t y0 = brick.y * kBrickSide;
  for (std::int32_t vy = std::max(y.first, y0); vy <= std::min(y.last, y0 + kBrickSide - 1); ++vy) {
    for (std::int32_t vx = std::max(x.first, x0); vx <= std::min(x.last, x0 + kBrickSide - 1);
         ++vx) {
      mask |= std::uint64_t{1} << ((vx - x0) + kBrickSide * (vy - y0));
    }
  }
  return mask;
}

std::int32_t floor_to(std::int32_t value, std::int32_t step) {
  return static_cast<std::int32_t>(std::floor(static_cast<double>(value) / step)) * step;
}

}  // namespace

void VoxelColumns::clear() {
  box_ = {};
  columns_.clear();
  resolution_m_ = 0;
}

bool VoxelColumns::grow_to(Cell low, Cell high) {
  if (box_.contains(low) && box_.contains(high)) return true;
  CellBox wanted = box_;
  if (wanted.size() == 0) {
    wanted = {floor_to(low.x, kGrowth), floor_to(low.y, kGrowth), 1, 1};
  }
  const std::int32_t x0 = std::min(wanted.x0, floor_to(low.x, kGrowth));
  const std::int32_t y0 = std::min(wanted.y0, floor_to(low.y, kGrowth));
  const std::int32_t x1 = std::max(wanted.x0 + wanted.width, floor_to(high.x, kGrowth) + kGrowth);
  const std::int32_t y1 = std::max(wanted.y0 + wanted.height, floor_to(high.y, kGrowth) + kGrowth);
  if (x1 - x0 > kMaxSide || y1 - y0 > kMaxSide) return false;
  wanted = {x0, y0, x1 - x0, y1 - y0};
  std::vector<Column> columns(wanted.size());
  for (std::size_t i = 0; i < columns_.size(); ++i) {
    columns[wanted.index(box_.cell(i))] = columns_[i];
  }
  box_ = wanted;
  columns_ = std::move(columns);
  return true;
}

void VoxelColumns::cover(const Eigen::Vector2d& centre_m, double half_side_m) {
  const Eigen::Vector2d half(half_side_m, half_side_m);
  (void)grow_to(cell_at(centre_m - half), cell_at(centre_m + half));
}

void VoxelColumns::update(const mapping::MapReplica& map, std::span<const BrickIndex> bricks) {
  if (map.resolution_m() <= 0) return;
  if (map.resolution_m() != resolution_m_) {
    std::fill(columns_.begin(), columns_.end(), Column{});
    resolution_m_ = map.resolution_m();
    layer_m_ = std::max(kThinnestLayer_m, resolution_m_);
  }
  for (const BrickIndex& brick : bricks) update_brick(map.grid(), brick);
}

void VoxelColumns::update_brick(const mapping::MapReplica::Grid& grid, BrickIndex brick) {
  const double side_m = kBrickSide * resolution_m_;
  const int first = std::max(0, layer_of(brick.z * side_m));
  const int last = std::min(kLayers - 1, layer_of((brick.z + 1) * side_m - 1e-6));
  if (first > last) return;
  const Cell low = cell_at({brick.x * side_m + kRounding_m, brick.y * side_m + kRounding_m});
  const Cell high =
      cell_at({(brick.x + 1) * side_m - kRounding_m, (brick.y + 1) * side_m - kRounding_m});
  if (!grow_to(low, high)) return;
  for (std::int32_t y = low.y; y <= high.y; ++y) {
    for (std::int32_t x = low.x; x <= high.x; ++x) read_layers(grid, {x, y}, first, last);
  }
}

void VoxelColumns::read_layers(const mapping::MapReplica::Grid& grid, Cell cell, int first,
                               int last) {
  const double side_m = kBrickSide * resolution_m_;
  const Span xs = voxels_in(cell.x * kCell_m, kCell_m, resolution_m_);
  const Span ys = voxels_in(cell.y * kCell_m, kCell_m, resolution_m_);
  const double low_m = bottom_m() + first * layer_m_;
  const double high_m = bottom_m() + (last + 1) * layer_m_;
  const auto z_first = static_cast<std::int32_t>(std::floor((low_m + kRounding_m) / side_m));
  const auto z_last = static_cast<std::int32_t>(std::floor((high_m - kRounding_m) / side_m));
  Column seen;
  for (std::int32_t z = z_first; z <= z_last; ++z) {
    for (std::int32_t y = ys.first >> 3; y <= ys.last >> 3; ++y) {
      for (std::int32_t x = xs.first >> 3; x <= xs.last >> 3; ++x) {
        const auto* content = grid.find({x, y, z});
        if (content != nullptr) add_layers(*content, z, layer_mask({x, y, z}, xs, ys), seen);
      }
    }
  }
  const std::uint64_t read = (~std::uint64_t{0} >> (63 - (last - first))) << first;
  Column& column = columns_[box_.index(cell)];
  column.occupied = (column.occupied & ~read) | (seen.occupied & read);
  column.free = (column.free & ~read) | (seen.free & read);
}

void VoxelColumns::add_layers(const mapping::ClassBrick& brick, std::int32_t brick_z,
                              std::uint64_t mask, Column& seen) const {
  for (int z = 0; z < kBrickSide; ++z) {
    const int layer = layer_of((brick_z * kBrickSide + z + 0.5) * resolution_m_);
    if (layer < 0 || layer >= kLayers) continue;
    const auto word = static_cast<std::size_t>(z);
    const std::uint64_t occupied = brick.occupied.words[word] & mask;
    const std::uint64_t free = brick.known.words[word] & ~brick.occupied.words[word] & mask;
    seen.occupied |= std::uint64_t{occupied != 0} << layer;
    seen.free |= std::uint64_t{free != 0} << layer;
  }
}

int VoxelColumns::layer_of(double z_m) const {
  return static_cast<int>(std::floor((z_m - bottom_m()) / layer_m_ + 1e-9));
}

}  // namespace cairn::planning
