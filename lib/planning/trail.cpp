// SPDX-License-Identifier: Apache-2.0
#include "planning/trail.hpp"

#include <algorithm>

namespace cairn::planning {
void Trail::stand(const Eigen::Vector2d& at_m, double height_m) {
  floor_.push_back({at_m, stand_radius_m_, height_m});
}

bool Trail::drive(const Eigen::Vector2d& at_m, double height_m) {
  if (!floor_.empty() && (floor_.back().at_m - at_m).norm() < kSpacing_m) return false;
  if (floor_.size() >= kLongest) {
    std::size_t old = 0;
    std::erase_if(floor_, [&](const KnownFloor& floor) {
      return ++old < kLongest / 10 && floor.radius_m <= track_radius_m_;
    });
  }
  floor_.push_back({at_m, track_radius_m_, height_m});
  return true;
}

std::vector<Eigen::Vector2d> Trail::way_back_m(double length_m) const {
  std::vector<Eigen::Vector2d> way;
  for (auto floor = floor_.rbegin(); floor != floor_.rend() && length_m > 0; ++floor) {
    if (!way.empty()) length_m -= (floor->at_m - way.back()).norm();
    way.push_back(floor->at_m);
  }
  return way;
}

}  // namespace cairn::planning
