// SPDX-License-Identifier: Apache-2.0
#include "planning/shadows.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace cairn::planning {
namespace {

constexpr double kLeastRange_m = 0.05;

}  // namespace

Shadows::Shadows(const Eigen::Vector2d& eye_m) : eye_m_{eye_m} {
  from_m_.fill(std::numeric_limits<float>::infinity());
}

int Shadows::bearing_of(double left_rad) {
  return static_cast<int>(std::floor((left_rad / std::numbers::pi + 1) * (kBearings / 2)));
}

void Shadows::add(const Eigen::Vector2d& at_m, double size_m) {
  const Eigen::Vector2d way = at_m - eye_m_;
  const double range_m = std::max(kLeastRange_m, way.norm());
  const double bearing_rad = std::atan2(way.y(), way.x());
  const double half_rad = std::min(0.5 * size_m / range_m, 1.0);
  const int last = bearing_of(bearing_rad + half_rad);
  for (int b = bearing_of(bearing_rad - half_rad); b <= last; ++b) {
    float& from_m = from_m_[static_cast<std::size_t>((b + kBearings) % kBearings)];
    from_m = std::min(from_m, static_cast<float>(range_m));
  }
}

bool Shadows::hide(const Eigen::Vector2d& at_m) const {
  const Eigen::Vector2d way = at_m - eye_m_;
  const int bearing = bearing_of(std::atan2(way.y(), way.x()));
  return way.norm() > static_cast<double>(from_m_[static_cast<std::size_t>(bearing % kBearings)]);
}

}  // namespace cairn::planning
