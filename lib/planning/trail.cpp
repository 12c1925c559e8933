// SPDX-License-Identifier: Apache-2.0
#include "planning/trail.hpp"

#include <algorithm>

namespace cairn::planning {
namespace {

constexpr std::size_t kLately = 30;
constexpr double kBeside_m = 0.12;

}  // namespace

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

bool Trail::leads_over(const Eigen::Vector2d& at_m) const {
  const std::size_t count = std::min(kLately, floor_.size());
  return std::any_of(floor_.end() - static_cast<std::ptrdiff_t>(count), floor_.end(),
                     [&](const KnownFloor& f) { return (f.at_m - at_m).norm() < kBeside_m; });
}

}  // namespace cairn::planning
