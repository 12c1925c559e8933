// SPDX-License-Identifier: Apache-2.0
#include "planning/path_search.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <queue>

namespace cairn::planning {
namespace {

constexpr std::uint8_t kStart = 8;
constexpr float kEscapeCost = 12;

/// Ordered by cost, then by place, so that equal costs come in one order everywhere.
struct Open {
  float estimate;
  std::uint32_t index;
  friend bool operator>(const Open& a, const Open& b) {
    return a.estimate != b.estimate ? a.estimate > b.estimate : a.index > b.index;
  }
};
using OpenQueue = std::priority_queue<Open, std::vector<Open>, std::greater<>>;

double octile_m(Cell a, Cell b) {
  const int dx = std::abs(a.x - b.x);
  const int dy = std::abs(a.y - b.y);
  return kCell_m * (std::max(dx, dy) + (std::numbers::sqrt2 - 1) * std::min(dx, dy));
}

/// One search: `estimate` is a lower bound of the cost from a cell on, `done` ends it.
template <class Estimate, class Done>
RouteField search(const CostGrid& costs, Cell from, Estimate&& estimate, Done&& done) {
  RouteField field{costs.box, from, {}, {}};
  field.cost.assign(costs.values.size(), kImpassable);
  field.parent.assign(costs.values.size(), kStart);
  if (!costs.box.contains(from) || costs.at(from, kImpassable) == kImpassable) return field;
  OpenQueue open;
  field.cost[costs.box.index(from)] = 0;
  open.push({estimate(from), static_cast<std::uint32_t>(costs.box.index(from))});
  while (!open.empty()) {
    const Open next = open.top();
    open.pop();
    const Cell cell = costs.box.cell(next.index);
    const float cost = field.cost[next.index];
    if (next.estimate > cost + estimate(cell)) continue;
    if (done(cell)) break;
    for (std::uint8_t s = 0; s < 8; ++s) {
      const CellStep step = kEightSteps[s];
      const Cell to = cell + step;
      const float there = costs.at(to, kImpassable);
      if (there == kImpassable) continue;
      const bool diagonal = step.x != 0 && step.y != 0;
      if (diagonal && (costs.at({to.x, cell.y}, kImpassable) == kImpassable ||
                       costs.at({cell.x, to.y}, kImpassable) == kImpassable)) {
        continue;
      }
      const double length_m = diagonal ? std::numbers::sqrt2 * kCell_m : kCell_m;
      const auto step_cost = static_cast<float>(
          length_m * 0.5 * (static_cast<double>(costs.values[next.index]) + there));
      const std::size_t j = costs.box.index(to);
      if (cost + step_cost >= field.cost[j]) continue;
      field.cost[j] = cost + step_cost;
      field.parent[j] = s;
      open.push({field.cost[j] + estimate(to), static_cast<std::uint32_t>(j)});
    }
  }
  return field;
}

}  // namespace

CostGrid route_costs(const GroundMap& ground, double turning_radius_m, const RouteConfig& config) {
  CostGrid costs(ground.box, kImpassable);
  const double limit_m = turning_radius_m + config.margin_m;
  for (std::size_t i = 0; i < costs.values.size(); ++i) {
    if (ground.classes[i] != ColumnClass::kFree) continue;
    const double spare_m = ground.to_obstacle_m.values[i] - limit_m;
    if (spare_m < 0) continue;
    const double nearness = std::max(0.0, 1 - spare_m / config.comfort_m);
    costs.values[i] = static_cast<float>(1 + config.shyness * nearness * nearness);
  }
  return costs;
}

void open_around(const GroundMap& ground, const Eigen::Vector2d& at_m, double radius_m,
                 CostGrid& costs) {
  const Eigen::Vector2d half(radius_m, radius_m);
  const Cell low = cell_at(at_m - half);
  const Cell high = cell_at(at_m + half);
  for (std::int32_t y = low.y; y <= high.y; ++y) {
    for (std::int32_t x = low.x; x <= high.x; ++x) {
      const Cell cell{x, y};
      if (ground.at(cell) != ColumnClass::kFree || (centre_m(cell) - at_m).norm() > radius_m)
        continue;
      float& cost = costs.values[costs.box.index(cell)];
      if (cost == kImpassable) cost = kEscapeCost;
    }
  }
}

RouteField all_routes(const CostGrid& costs, Cell from) {
  return search(
      costs, from, [](Cell) { return 0.0F; }, [](Cell) { return false; });
}

std::vector<Cell> route_to(const RouteField& field, Cell to) {
  std::vector<Cell> cells;
  if (!field.reaches(to)) return cells;
  for (Cell cell = to;;) {
    cells.push_back(cell);
    const std::uint8_t s = field.parent[field.box.index(cell)];
    if (s == kStart) break;
    cell = {cell.x - kEightSteps[s].x, cell.y - kEightSteps[s].y};
  }
  std::reverse(cells.begin(), cells.end());
  return cells;
}

std::optional<Route> find_route(const CostGrid& costs, Cell from, Cell to) {
  // No metre costs less than 1; a little below, so that rounding never makes it too much.
  constexpr double kBelow = 0.9999;
  const RouteField field = search(
      costs, from, [&](Cell cell) { return static_cast<float>(kBelow * octile_m(cell, to)); },
      [&](Cell cell) { return cell == to; });
  if (!field.reaches(to)) return std::nullopt;
  return Route{route_to(field, to), field.cost[field.box.index(to)]};
}

}  // namespace cairn::planning
