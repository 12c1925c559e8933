// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "localization/distance_field.hpp"
#include "localization/random_source.hpp"

namespace cairn::localization {

/// Where a body may be, for guesses out of the blue: cells of the map that are known to be free at
/// the height of the body's middle, and no nearer to anything than its sides.
class FreeFloor {
 public:
  FreeFloor() = default;
  /// The layer at `z_m` of the map.
  FreeFloor(const DistanceField& field, double z_m, double clearance_m);

  [[nodiscard]] bool empty() const { return cells_.empty(); }
  [[nodiscard]] double area_m2() const {
    return static_cast<double>(cells_.size()) * cell_m_ * cell_m_;
  }
  /// Uniform over the whole; there must be some.
  [[nodiscard]] Eigen::Vector2d sample_m(RandomSource& random) const;

 private:
  struct Cell {
    std::int32_t x;
    std::int32_t y;
  };
  double cell_m_ = 0;
  std::vector<Cell> cells_;
};

}  // namespace cairn::localization
