// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>

namespace cairn::simulation {

/// Where somebody is.
struct PersonPose {
  std::size_t person = 0;  ///< index into World::people
  Eigen::Vector2d at_m = Eigen::Vector2d::Zero();
  double heading_rad = 0;
  double walked_m = 0;  ///< way so far: where the legs are in their swing
};

}  // namespace cairn::simulation
