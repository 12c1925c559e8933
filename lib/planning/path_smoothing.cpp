// SPDX-License-Identifier: Apache-2.0
#include "planning/path_smoothing.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace cairn::planning {
namespace {

constexpr double kCorner = 1e-9;
constexpr double kMoreCost =
    1.02;  // a straight line may cost this much more than the cells' stairs
constexpr std::size_t kLongestPiece = 60;  // cells
constexpr int kRoundings = 30;

/// Where a straight way crosses the grid's lines along one axis, as shares of the way.
struct Axis {
  double next;  ///< infinite: no more
  double each;
  std::int32_t step;

  Axis(double from_m, double way_m, std::int32_t cell, std::int32_t last)
      : next{std::numeric_limits<double>::infinity()},
        each{kCell_m / std::abs(way_m)},
        step{last > cell ? 1 : -1} {
    if (cell == last) return;
    const double inside = from_m / kCell_m - cell;
    next = std::max(0.0, (last > cell ? 1 - inside : inside) * each);
  }
  std::int32_t cross(std::int32_t cell, std::int32_t last) {
    next = cell + step == last ? std::numeric_limits<double>::infinity() : next + each;
    return cell + step;
  }
};

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
    for (int k = 1; k < count; ++k) {
      points.emplace_back(corners[i - 1] + way * (static_cast<double>(k) / count));
    }
    points.push_back(corners[i]);
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

// Cell by cell (Amanatides and Woo 1987); a line through a corner goes straight on.
double straight_cost(const CostGrid& costs, const Eigen::Vector2d& from_m,
                     const Eigen::Vector2d& to_m) {
  Cell cell = cell_at(from_m);
  const Cell last = cell_at(to_m);
  const Eigen::Vector2d way = to_m - from_m;
  Axis x(from_m.x(), way.x(), cell.x, last.x);
  Axis y(from_m.y(), way.y(), cell.y, last.y);
  double sum = 0;
  double share = 0;
  while (true) {
    const float cost = costs.at(cell, kImpassable);
    if (cost == kImpassable) return kImpassable;
    const double next = std::min({x.next, y.next, 1.0});
    sum += static_cast<double>(cost) * std::max(0.0, next - share);
    if (cell == last) return sum * way.norm();
    share = next;
    const double corner = std::min(x.next, y.next) + kCorner;
    if (x.next <= corner) cell.x = x.cross(cell.x, last.x);
    if (y.next <= corner) cell.y = y.cross(cell.y, last.y);
  }
}

std::vector<Eigen::Vector2d> smooth_path(const CostGrid& costs, std::span<const Cell> route) {
  if (route.empty()) return {};
  auto points = with_points_between(straighten(costs, route));
  round_corners(costs, points);
  return points;
}

}  // namespace cairn::planning
