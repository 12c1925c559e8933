// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "simulation/world.hpp"

namespace cairn::simulation {

/// The part of an upright line that lies inside a box.
struct InsideBox {
  double low_m;
  double high_m;
  double top_cosine;  ///< of the angle between the side through which it leaves and the level
};

/// Of the line at (x, y); nothing where it misses the box (slab method, Kay and Kajiya 1986).
[[nodiscard]] std::optional<InsideBox> upright_line_in(const Box& box, const Eigen::Vector2d& at_m);

}  // namespace cairn::simulation
