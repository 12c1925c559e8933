// SPDX-License-Identifier: Apache-2.0
#include "planning/traversability.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numbers>

#include "planning/distance_transform.hpp"

namespace cairn::planning {
namespace {

constexpr int kCarryCells = static_cast<int>(GroundMap::kCarry_m / kCell_m);
constexpr int kGapCells = 2;
constexpr double kPassesOver_m = 0.12;  // a ray this low over a gap tells that nothing stands there
constexpr double kRounding = 1e-6;

/// The layers whose middles lie between two heights.
class LayerRange {
 public:
  explicit LayerRange(const VoxelColumns& columns)
      : bottom_m_{columns.bottom_m()}, layer_m_{columns.layer_m()} {}

  [[nodiscard]] std::uint64_t between(double low_m, double high_m) const {
    const double low = std::ceil((low_m - bottom_m_) / layer_m_ - 0.5 - kRounding);
    const double high = std::floor((high_m - bottom_m_) / layer_m_ - 0.5 + kRounding);
    const int first = static_cast<int>(std::clamp(low, 0.0, 64.0));
    const int last = static_cast<int>(std::clamp(high, -1.0, 63.0));
    if (first > last) return 0;
    return (~std::uint64_t{0} >> (63 - (last - first))) << first;
  }

  /// Mean height of the middles of these layers.
  [[nodiscard]] double mean_m(std::uint64_t layers) const {
    int sum = 0;
    for (std::uint64_t left = layers; left != 0; left &= left - 1) sum += std::countr_zero(left);
    return bottom_m_ + layer_m_ * (static_cast<double>(sum) / std::popcount(layers) + 0.5);
  }

  [[nodiscard]] double lower_side_m(std::uint64_t layers) const {
    return bottom_m_ + layer_m_ * std::countr_zero(layers);
  }

 private:
  double bottom_m_;
  double layer_m_;
};

class Growth {
 public:
  Growth(const VoxelColumns& columns, const TraversabilityConfig& config, const RobotConfig& robot)
      : columns_{columns},
        layers_{columns},
        support_{config.support},
        tolerance_m_{config.step_m + columns.layer_m() / 2},
        slope_{std::tan(config.max_slope_deg * std::numbers::pi / 180)},
        head_m_{robot.height_m + config.headroom_m},
        track_radius_m_{robot.width_m / 2} {
    const std::size_t size = columns.box().size();
    ground_.box = columns.box();
    ground_.classes.assign(size, ColumnClass::kUnknown);
    ground_.reached.assign(size, 0);
    ground_.assumed.assign(size, 0);
    ground_.floor_m.assign(size, 0);
    ground_.ceiling_m.assign(size, std::numeric_limits<float>::infinity());
    carried_.assign(size, 0);
  }

  GroundMap run(std::span<const KnownFloor> known, std::span<const BlockedSpot> blocked) {
    // The newest knowledge counts where discs overlap.
    for (std::size_t i = known.size(); i-- > 0;) plant(known[i]);
    for (std::size_t at = 0; at < queue_.size(); ++at) spread(queue_[at]);
    close_gaps();
    for (const BlockedSpot& spot : blocked) block(spot);
    measure_clearance();
    return std::move(ground_);
  }

 private:
  template <class Visit>
  void for_disc(const Eigen::Vector2d& middle_m, double radius_m, Visit&& visit) {
    const Eigen::Vector2d half(radius_m, radius_m);
    const Cell low = cell_at(middle_m - half);
    const Cell high = cell_at(middle_m + half);
    for (std::int32_t y = low.y; y <= high.y; ++y) {
      for (std::int32_t x = low.x; x <= high.x; ++x) {
        const Cell cell{x, y};
        if (ground_.box.contains(cell) && (centre_m(cell) - middle_m).norm() <= radius_m) {
          visit(cell);
        }
      }
    }
  }

  void plant(const KnownFloor& floor) {
    const bool driven = floor.radius_m <= track_radius_m_ + kRounding;
    for_disc(floor.at_m, floor.radius_m, [&](Cell cell) {
      const std::size_t i = ground_.box.index(cell);
      if (driven) ground_.assumed[i] = 0;
      if (ground_.reached[i] != 0) return;
      judge(cell, i, floor.height_m);
      if (ground_.classes[i] == ColumnClass::kUnknown) {
        ground_.classes[i] = ColumnClass::kFree;
        ground_.assumed[i] = driven ? 0 : 1;
      }
      queue_.push_back(cell);
    });
  }

  void spread(Cell from) {
    const std::size_t i = ground_.box.index(from);
    for (const CellStep step : kFourSteps) {
      const Cell to = from + step;
      if (!ground_.box.contains(to)) continue;
      const std::size_t j = ground_.box.index(to);
      if (ground_.reached[j] != 0) continue;
      if (ground_.classes[i] == ColumnClass::kOccupied) {
        fill_obstacle(to, j, ground_.floor_m[i]);
        continue;
      }
      const int carried = ground_.classes[i] == ColumnClass::kFree ? 0 : carried_[i];
      if (carried >= kCarryCells) continue;
      judge(to, j, ground_.floor_m[i]);
      carried_[j] = static_cast<std::uint8_t>(carried + 1);
      queue_.push_back(to);
    }
  }

  // What is joined to an obstacle and just as much in the way is a part of it.
  void fill_obstacle(Cell cell, std::size_t i, double beside_m) {
    judge(cell, i, beside_m);
    if (ground_.classes[i] == ColumnClass::kOccupied) return queue_.push_back(cell);
    ground_.reached[i] = 0;
    ground_.classes[i] = ColumnClass::kUnknown;
    ground_.ceiling_m[i] = std::numeric_limits<float>::infinity();
  }

  // What a column is, next to floor of this height.
  void judge(Cell cell, std::size_t i, double beside_m) {
    const VoxelColumns::Column& column = columns_.column(i);
    const std::uint64_t at_floor =
        layers_.between(beside_m - tolerance_m_, beside_m + tolerance_m_);
    const std::uint64_t floor = column.occupied & at_floor;
    double floor_m = beside_m;
    if (floor != 0) {
      const double rise_m = slope_ * kCell_m;
      floor_m = std::clamp(layers_.mean_m(floor), beside_m - rise_m, beside_m + rise_m);
    }
    ground_.reached[i] = 1;
    ground_.floor_m[i] = static_cast<float>(floor_m);
    const std::uint64_t over = layers_.between(floor_m + tolerance_m_ + kRounding, 1e3);
    if ((column.occupied & over) != 0) {
      ground_.ceiling_m[i] = static_cast<float>(layers_.lower_side_m(column.occupied & over));
    }
    if (obstructed(cell, column, over & layers_.between(-1e3, floor_m + head_m_)) ||
        (floor == 0 && drops(column, floor_m))) {
      ground_.classes[i] = ColumnClass::kOccupied;
    } else {
      ground_.classes[i] = floor != 0 ? ColumnClass::kFree : ColumnClass::kUnknown;
    }
  }

  bool obstructed(Cell cell, const VoxelColumns::Column& column, std::uint64_t body) const {
    int support = std::popcount(column.occupied & body);
    if (support == 0) return false;
    for (const CellStep step : kEightSteps) {
      const Cell beside = cell + step;
      if (!ground_.box.contains(beside)) continue;
      support += std::popcount(columns_.column(ground_.box.index(beside)).occupied & body);
    }
    return support >= support_;
  }

  // Rays went down through the floor's height, and something lies below.
  bool drops(const VoxelColumns::Column& column, double floor_m) const {
    const double below_m = floor_m - tolerance_m_ - kRounding;
    const std::uint64_t through = layers_.between(below_m - 2 * columns_.layer_m(), floor_m);
    return (column.free & through) != 0 && (column.occupied & layers_.between(-1e3, below_m)) != 0;
  }

  bool floor_within_gap(Cell from, CellStep step) const {
    for (int i = 0; i < kGapCells; ++i) {
      from = from + step;
      if (!ground_.box.contains(from)) return false;
      const std::size_t j = ground_.box.index(from);
      if (ground_.classes[j] == ColumnClass::kOccupied) return false;
      if (ground_.classes[j] == ColumnClass::kFree) return true;
    }
    return false;
  }

  void close_gaps() {
    std::vector<std::size_t> closed;
    for (std::size_t i = 0; i < ground_.classes.size(); ++i) {
      if (ground_.reached[i] == 0 || ground_.classes[i] != ColumnClass::kUnknown) continue;
      const double floor_m = ground_.floor_m[i];
      const bool passed_over =
          (columns_.column(i).free & layers_.between(floor_m, floor_m + kPassesOver_m)) != 0;
      if (!passed_over) continue;
      const Cell cell = ground_.box.cell(i);
      for (const CellStep step : {CellStep{1, 0}, {0, 1}, {1, 1}, {1, -1}}) {
        if (floor_within_gap(cell, step) && floor_within_gap(cell, {-step.x, -step.y})) {
          closed.push_back(i);
          break;
        }
      }
    }
    for (const std::size_t i : closed) ground_.classes[i] = ColumnClass::kFree;
  }

  void block(const BlockedSpot& spot) {
    for_disc(spot.at_m, spot.radius_m,
             [&](Cell cell) { ground_.classes[ground_.box.index(cell)] = ColumnClass::kOccupied; });
  }

  void measure_clearance() {
    std::vector<std::uint8_t> occupied(ground_.classes.size());
    for (std::size_t i = 0; i < occupied.size(); ++i) {
      occupied[i] = ground_.classes[i] == ColumnClass::kOccupied ? 1 : 0;
    }
    ground_.to_obstacle_m = distance_to_marked_m(ground_.box, occupied);
    for (float& distance_m : ground_.to_obstacle_m.values) {
      distance_m = std::max(0.0F, distance_m - static_cast<float>(kCell_m / 2));
    }
  }

  const VoxelColumns& columns_;
  LayerRange layers_;
  int support_;
  double tolerance_m_;
  double slope_;
  double head_m_;
  double track_radius_m_;
  GroundMap ground_;
  std::vector<std::uint8_t> carried_;
  std::vector<Cell> queue_;
};

}  // namespace

GroundMap judge_ground(const VoxelColumns& columns, std::span<const KnownFloor> known,
                       std::span<const BlockedSpot> blocked, const TraversabilityConfig& config,
                       const RobotConfig& robot) {
  return Growth(columns, config, robot).run(known, blocked);
}

}  // namespace cairn::planning
