// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "core/geometry.hpp"

namespace cairn::simulation {

/// How two solids lie to each other.
struct Contact {
  /// Below 0: how deep they overlap, by the direction in which a level push parts them soonest.
  /// Above 0: at most how far they are apart [m].
  double gap_m = 0;
  /// Unit vector, level: where the first one must be pushed to get away from the other.
  Eigen::Vector2d away = Eigen::Vector2d::UnitX();
};

/// Two boxes, each a frame in its middle and half its size along the frame's axes: the separating
/// axes of Gottschalk, Lin and Manocha (1996, section 5), looked at for level pushes only. Two
/// boxes one above the other, or too far up or down to touch, are apart whatever their plans say.
[[nodiscard]] Contact box_contact(const Isometry& T_world_a, const Eigen::Vector3d& half_a_m,
                                  const Isometry& T_world_b, const Eigen::Vector3d& half_b_m);

}  // namespace cairn::simulation
