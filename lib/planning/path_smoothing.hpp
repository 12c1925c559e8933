// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "planning/path_search.hpp"

namespace cairn::planning {

/// Middles of a route's cells, straightened: pieces that a straight line covers for no more cost
/// are replaced by it, then points stand at most kPointSpacing_m apart and corners are rounded
/// where there is room. First and last point stay. Every point and all between lies in a passable
/// cell.
inline constexpr double kPointSpacing_m = 0.05;
[[nodiscard]] std::vector<Eigen::Vector2d> smooth_path(const CostGrid& costs,
                                                       std::span<const Cell> route);

/// What the straight way between two points costs; infinite if it leaves passable cells.
[[nodiscard]] double straight_cost(const CostGrid& costs, const Eigen::Vector2d& from_m,
                                   const Eigen::Vector2d& to_m);

}  // namespace cairn::planning
