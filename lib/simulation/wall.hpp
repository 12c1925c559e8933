// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "core/result.hpp"
#include "simulation/world.hpp"

namespace cairn::simulation {

/// Each wall is longer than from its beginning to its end by this share of its thickness at either
/// end, so that walls that meet leave no gap, and no face of one lies in a face of the other.
inline constexpr double kWallOverlap = 0.45;

/// The boxes that a wall consists of: what stands between its doors, and what spans them. Material
/// and pictures are left to the caller; `key` begins each error.
[[nodiscard]] Result<std::vector<Box>> wall_pieces(const WallConfig& wall, const std::string& key);

}  // namespace cairn::simulation
