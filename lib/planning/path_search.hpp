// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "core/config.hpp"
#include "planning/cell_grid.hpp"
#include "planning/traversability.hpp"

namespace cairn::planning {

struct RouteConfig {
  double margin_m = 0.03;
  double comfort_m = 0.35;
  double shyness = 3;

  void visit(ConfigVisitor& v) {
    v.number("margin_m", margin_m, {0, 1}, "m", "kept to obstacles beyond the turning circle");
    v.number("comfort_m", comfort_m, {0.01, 3}, "m",
             "nearer than this to that limit every metre costs more");
    v.number("shyness", shyness, {0, 100}, "", "by so many times more at the limit itself");
  }
};

/// What a metre costs in each cell; infinite where the robot's middle must not be.
using CostGrid = CellGrid<float>;

inline constexpr float kImpassable = std::numeric_limits<float>::infinity();

/// Free ground with turning_radius_m + margin_m to every obstacle is passable: 1 a metre, and
/// towards the limit up to 1 + shyness, quadratically.
[[nodiscard]] CostGrid route_costs(const GroundMap& ground, double turning_radius_m,
                                   const RouteConfig& config);

/// Opens what lies around the robot: a robot that finds itself nearer to something than it should
/// be may leave. Free cells within radius_m get a high cost, unless they are passable already.
void open_around(const GroundMap& ground, const Eigen::Vector2d& at_m, double radius_m,
                 CostGrid& costs);

/// Costs of the cheapest ways from one cell to all others: 8-connected; a step costs its length
/// times the mean of its ends' costs; diagonal steps need both cells beside them passable.
struct RouteField {
  CellBox box;
  Cell from;
  std::vector<float> cost;           ///< infinite: no way
  std::vector<std::uint8_t> parent;  ///< kEightSteps index that led here; 8 at the start

  [[nodiscard]] bool reaches(Cell cell) const {
    return box.contains(cell) && cost[box.index(cell)] < kImpassable;
  }
};

/// Dijkstra (1959).
[[nodiscard]] RouteField all_routes(const CostGrid& costs, Cell from);

/// From field.from to `to`, both included; empty if there is no way.
[[nodiscard]] std::vector<Cell> route_to(const RouteField& field, Cell to);

struct Route {
  std::vector<Cell> cells;
  double cost = 0;
};

/// The cheapest way between two cells by the same costs, by A* (Hart, Nilsson and Raphael 1968).
[[nodiscard]] std::optional<Route> find_route(const CostGrid& costs, Cell from, Cell to);

}  // namespace cairn::planning
