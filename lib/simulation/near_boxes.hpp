// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <memory>
#include <span>
#include <vector>

#include "simulation/world.hpp"

namespace cairn::simulation {

/// The few boxes of a world that somebody who goes about meets next.
class NearBoxes {
 public:
  /// `reach_m`: how far from their middle anything of them gets.
  NearBoxes(std::shared_ptr<const World> world, double reach_m);

  /// All boxes that somebody at this place may touch or stand on, and a few more, in the world's
  /// order. Cheap for a place near the one before.
  [[nodiscard]] std::span<const Box* const> at(const Eigen::Vector2d& place_m);

 private:
  std::shared_ptr<const World> world_;
  double reach_m_;
  std::vector<Eigen::AlignedBox2d> plans_;  ///< of each box
  Eigen::Vector2d gathered_at_m_;
  std::vector<const Box*> near_;
};

}  // namespace cairn::simulation
