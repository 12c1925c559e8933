// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "core/geometry.hpp"
#include "core/result.hpp"
#include "simulation/world.hpp"

namespace cairn::simulation {

/// Something upright and round that goes about on the floor.
struct Walker {
  double radius_m = 0.234;
  double height_m = 0.4;
  double max_step_m = 0.02;
  double max_slope_rad = 0.18;  ///< a little over 10 degrees
};

/// Where a walker gets to from its start, as squares of the plan.
class ReachableFloor {
 public:
  /// Side of a square. Inside, lines 1 cm apart are followed from one to the next.
  static constexpr double kCell_m = 0.05;

  struct Cell {
    Eigen::Vector3d middle_m;  ///< on the ground
    int index;                 ///< row * cols + col
  };

  /// Floods the ground from below the start (x, y on the level of z = 0): over steps and slopes
  /// that the walker takes, never into a box, never down an edge. Fails where the walker does not
  /// fit at the start.
  [[nodiscard]] static Result<ReachableFloor> flood(const World& world,
                                                    const Eigen::Vector2d& start_m,
                                                    const Walker& walker);

  /// True where the walker's middle can be. Exact to about 1 cm.
  [[nodiscard]] bool has_room_at(const Eigen::Vector2d& at_m) const;

  /// The floor that the walker gets to cover: cells whose middle it does, row by row.
  [[nodiscard]] const std::vector<Cell>& cells() const { return cells_; }

  /// Of the cell at (x, y), in cells(); -1 where it is none of them.
  [[nodiscard]] int cell_at(const Eigen::Vector2d& at_m) const;

  [[nodiscard]] double area_m2() const {
    return static_cast<double>(cells_.size()) * kCell_m * kCell_m;
  }

 private:
  Eigen::Vector2d corner_m_ = Eigen::Vector2d::Zero();
  int cols_ = 0;  ///< of lines
  int rows_ = 0;
  std::vector<std::uint8_t> room_;  ///< of each line: whether the walker's middle can be there
  std::vector<Cell> cells_;
  std::vector<std::int32_t> cell_of_;  ///< of each square of the plan: place in cells_, or -1
};

}  // namespace cairn::simulation
