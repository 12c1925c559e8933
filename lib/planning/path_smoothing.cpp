// SPDX-License-Identifier: Apache-2.0
#include "planning/path_smoothing.hpp"

#include <algorithm>
#include <cmath>

namespace cairn::planning {
namespace {

constexpr double kSample_m = 0.02;
constexpr double kMoreCost =
    1.02;  // a straight line may cost this much more than the cells' stairs
constexpr std::size_t kLongestPiece = 60;  // cells
constexpr int kRoundings = 30;

std::vector<Eigen::Vector2d> straighten(const CostGrid& costs, std::span<const Cell> route) {
  std::vector<Eigen::Vector2d> corners{centre_m(route.front())};
  std::vector<double> along{0};
  for (std::size_t i = 1; i < route.size(); ++i) {
    along.push_back(along.back() +
                    straight_cost(costs, centre_m(route[i - 1]), centre_m(route[i])));
  }
  std::size_t from = 0;
  while (from + 1 < route.size()) {
    std::size_t to = from + 1;
    for (std::size_t far = std::min(route.size() - 1, from + kLongestPiece); far > to; --far) {
      const double straight = straight_cost(costs, centre_m(route[from]), centre_m(route[far]));
      if (straight <= kMoreCost * (along[far] - along[from])) {
        to = far;
        break;
      }
    }
    corners.push_back(centre_m(route[to]));
    from = to;
  }
  return corners;
}

std::vector<Eigen::Vector2d> with_points_between(const std::vector<Eigen::Vector2d>& corners) {
  std::vector<Eigen::Vector2d> points{corners.front()};
  for (std::size_t i = 1; i < corners.size(); ++i) {
    const Eigen::Vector2d way = corners[i] - corners[i - 1];
    const int count = std::max(1, static_cast<int>(std::ceil(way.norm() / kPointSpacing_m - 1e-9)));
    for (int k = 1; k <= count; ++k) {
      points.emplace_back(corners[i - 1] + way * (static_cast<double>(k) / count));
    }
  }
  return points;
}

void round_corners(const CostGrid& costs, std::vector<Eigen::Vector2d>& points) {
  for (int round = 0; round < kRoundings; ++round) {
    for (std::size_t i = 1; i + 1 < points.size(); ++i) {
      const Eigen::Vector2d middle = 0.5 * points[i] + 0.25 * (points[i - 1] + points[i + 1]);
      const auto now = costs.at(cell_at(points[i]), kImpassable);
      const auto then = costs.at(cell_at(middle), kImpassable);
      if (then > kMoreCost * now) continue;
      if (straight_cost(costs, points[i - 1], middle) == kImpassable ||
          straight_cost(costs, middle, points[i + 1]) == kImpassable) {
        continue;
      }
      points[i] = middle;
    }
  }
}

}  // namespace

double straight_cost(const CostGrid& costs, const Eigen::Vector2d& from_m,
                     const Eigen::Vector2d& to_m) {
  const double length_m = (to_m - from_m).norm();
  const int steps = std::max(1, static_cast<int>(std::ceil(length_m / kSample_m)));
  double sum = 0;
  for (int i = 0; i <= steps; ++i) {
    const Eigen::Vector2d at = from_m + (to_m - from_m) * (static_cast<double>(i) / steps);
    const float cost = costs.at(cell_at(at), kImpassable);
    if (cost == kImpassable) return kImpassable;
    sum += (i == 0 || i == steps ? 0.5 : 1) * static_cast<double>(cost);
  }
  return sum * length_m / steps;
}

std::vector<Eigen::Vector2d> smooth_path(const CostGrid& costs, std::span<const Cell> route) {
  if (route.empty()) return {};
  auto points = with_points_between(straighten(costs, route));
  round_corners(costs, points);
  return points;
}

}  // namespace cairn::planning
