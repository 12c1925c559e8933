// SPDX-License-Identifier: Apache-2.0
#include "simulation/near_boxes.hpp"

#include <limits>
#include <utility>

namespace cairn::simulation {
namespace {

/// So far somebody goes before the boxes are gathered anew.
constexpr double kStride_m = 0.3;

}  // namespace

NearBoxes::NearBoxes(std::shared_ptr<const World> world, double reach_m)
    : world_{std::move(world)},
      reach_m_{reach_m},
      gathered_at_m_{Eigen::Vector2d::Constant(std::numeric_limits<double>::infinity())} {
  for (const Box& box : world_->boxes) {
    const Eigen::Vector2d half_m =
        (box.T_world_box.linear().cwiseAbs() * box.half_size_m).head<2>();
    const Eigen::Vector2d middle_m = box.T_world_box.translation().head<2>();
    plans_.emplace_back(middle_m - half_m, middle_m + half_m);
  }
}

std::span<const Box* const> NearBoxes::at(const Eigen::Vector2d& place_m) {
  if ((place_m - gathered_at_m_).norm() <= kStride_m) return near_;
  gathered_at_m_ = place_m;
  near_.clear();
  for (std::size_t i = 0; i < plans_.size(); ++i) {
    if (plans_[i].exteriorDistance(place_m) <= reach_m_ + kStride_m)
      near_.push_back(&world_->boxes[i]);
  }
  return near_;
}

}  // namespace cairn::simulation
