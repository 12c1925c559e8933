// SPDX-License-Identifier: Apache-2.0
#include "simulation/upright_line.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace cairn::simulation {

std::optional<InsideBox> upright_line_in(const Box& box, const Eigen::Vector2d& at_m) {
  constexpr double kParallel = 1e-9;
  const Eigen::Matrix3d R_box_world = box.T_world_box.linear().transpose();
  const Eigen::Vector3d origin =
      R_box_world * (Eigen::Vector3d(at_m.x(), at_m.y(), 0) - box.T_world_box.translation());
  const Eigen::Vector3d up = R_box_world.col(2);
  InsideBox inside{-std::numeric_limits<double>::infinity(),
                   std::numeric_limits<double>::infinity(), 0};
  for (int axis = 0; axis < 3; ++axis) {
    const double half_m = box.half_size_m(axis);
    if (std::abs(up(axis)) < kParallel) {
      if (std::abs(origin(axis)) > half_m) return std::nullopt;
      continue;
    }
    const double a = (-half_m - origin(axis)) / up(axis);
    const double b = (half_m - origin(axis)) / up(axis);
    inside.low_m = std::max(inside.low_m, std::min(a, b));
    if (std::max(a, b) < inside.high_m) {
      inside.high_m = std::max(a, b);
      inside.top_cosine = std::abs(up(axis));
    }
  }
  if (inside.low_m > inside.high_m) return std::nullopt;
  return inside;
}

}  // namespace cairn::simulation
