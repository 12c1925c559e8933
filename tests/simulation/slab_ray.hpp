// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "simulation/world.hpp"

namespace cairn::simulation {

/// Where a ray first enters a box, as a multiple of the direction, from outside all boxes: the slab
/// method (Kay and Kajiya 1986), in double, box by box. Infinity where it meets none.
inline double first_hit(const World& world, const Eigen::Vector3d& origin_m,
                        const Eigen::Vector3d& direction) {
  double first = std::numeric_limits<double>::infinity();
  for (const Box& box : world.boxes) {
    const Isometry T_box_world = box.T_world_box.inverse();
    const Eigen::Vector3d o = T_box_world * origin_m;
    const Eigen::Vector3d d = T_box_world.linear() * direction;
    double enter = 0;
    double leave = std::numeric_limits<double>::infinity();
    for (int axis = 0; axis < 3; ++axis) {
      const double a = (-box.half_size_m(axis) - o(axis)) / d(axis);
      const double b = (box.half_size_m(axis) - o(axis)) / d(axis);
      enter = std::max(enter, std::min(a, b));
      leave = std::min(leave, std::max(a, b));
    }
    if (enter <= leave && enter > 0) first = std::min(first, enter);
  }
  return first;
}

}  // namespace cairn::simulation
