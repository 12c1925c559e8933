// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "planning/cell_grid.hpp"

namespace cairn::planning {

/// From the middle of each cell to the middle of the nearest marked one [m]: exact Euclidean
/// (Felzenszwalb and Huttenlocher 2012). Infinite where nothing is marked.
[[nodiscard]] CellGrid<float> distance_to_marked_m(const CellBox& box,
                                                   const std::vector<std::uint8_t>& marked);

}  // namespace cairn::planning
