// SPDX-License-Identifier: Apache-2.0
#include "planning/path_search.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "planning/distance_transform.hpp"
#include "planning/path_smoothing.hpp"

namespace cairn::planning {
namespace {

CostGrid random_costs(std::mt19937& random, int side, double blocked) {
  std::uniform_real_distribution<double> share(0, 1);
  CostGrid costs({-side / 2, -side / 2, side, side}, 1);
  for (float& cost : costs.values) {
    cost = share(random) < blocked ? kImpassable : static_cast<float>(1 + 4 * share(random));
  }
  return costs;
}

double step_cost(const CostGrid& costs, Cell from, CellStep step) {
  const Cell to = from + step;
  const double a = costs.at(from, kImpassable);
  const double b = costs.at(to, kImpassable);
  if (step.x != 0 && step.y != 0 &&
      (costs.at({to.x, from.y}, kImpassable) == kImpassable ||
       costs.at({from.x, to.y}, kImpassable) == kImpassable)) {
    return kImpassable;
  }
  return std::hypot(step.x, step.y) * kCell_m * 0.5 * (a + b);
}

/// Costs from one cell to all by relaxing every step until nothing changes (Bellman and Ford).
std::vector<double> relaxed(const CostGrid& costs, Cell from) {
  std::vector<double> cost(costs.values.size(), kImpassable);
  if (costs.at(from, kImpassable) == kImpassable) return cost;
  cost[costs.box.index(from)] = 0;
  for (bool changed = true; changed;) {
    changed = false;
    for (std::size_t i = 0; i < cost.size(); ++i) {
      if (cost[i] == kImpassable) continue;
      for (const CellStep step : kEightSteps) {
        const Cell to = costs.box.cell(i) + step;
        if (!costs.box.contains(to)) continue;
        const double through = cost[i] + step_cost(costs, costs.box.cell(i), step);
        if (through < cost[costs.box.index(to)] - 1e-12) {
          cost[costs.box.index(to)] = through;
          changed = true;
        }
      }
    }
  }
  return cost;
}

TEST(PathSearch, FindsTheCheapestWayOrNone) {
  constexpr unsigned kSeed = 17;
  std::mt19937 random(kSeed);
  int ways = 0;
  for (int round = 0; round < 60; ++round) {
    const CostGrid costs = random_costs(random, 24, 0.05 * (round % 9));
    const Cell from = costs.box.cell(random() % costs.values.size());
    const auto truth = relaxed(costs, from);
    const RouteField field = all_routes(costs, from);
    for (int k = 0; k < 10; ++k) {
      const std::size_t goal = random() % costs.values.size();
      const Cell to = costs.box.cell(goal);
      const auto route = find_route(costs, from, to);
      ASSERT_EQ(route.has_value(), truth[goal] < kImpassable) << "round " << round;
      ASSERT_EQ(field.reaches(to), route.has_value());
      if (!route) continue;
      ++ways;
      EXPECT_NEAR(route->cost, truth[goal], 1e-4 * (1 + truth[goal]));
      EXPECT_NEAR(field.cost[goal], truth[goal], 1e-4 * (1 + truth[goal]));
      EXPECT_EQ(route->cells.front(), from);
      EXPECT_EQ(route->cells.back(), to);
      double sum = 0;
      for (std::size_t i = 1; i < route->cells.size(); ++i) {
        const CellStep step{route->cells[i].x - route->cells[i - 1].x,
                            route->cells[i].y - route->cells[i - 1].y};
        ASSERT_LE(std::max(std::abs(step.x), std::abs(step.y)), 1);
        sum += step_cost(costs, route->cells[i - 1], step);
      }
      EXPECT_NEAR(sum, truth[goal], 1e-4 * (1 + truth[goal]));
    }
  }
  EXPECT_GT(ways, 100);
}

TEST(PathSearch, KeepsAwayFromWallsWhereThereIsRoom) {
  GroundMap ground;
  ground.box = {0, 0, 60, 60};
  ground.classes.assign(ground.box.size(), ColumnClass::kFree);
  std::vector<std::uint8_t> occupied(ground.box.size(), 0);
  for (std::int32_t x = 0; x < 60; ++x) {
    ground.classes[ground.box.index({x, 0})] = ColumnClass::kOccupied;
    occupied[ground.box.index({x, 0})] = 1;
  }
  ground.to_obstacle_m = distance_to_marked_m(ground.box, occupied);
  const CostGrid costs = route_costs(ground, 0.234, {});
  EXPECT_EQ(costs.at({30, 4}, 0), kImpassable);
  const auto route = find_route(costs, {5, 6}, {55, 6});
  ASSERT_TRUE(route);
  std::int32_t farthest = 0;
  for (const Cell& cell : route->cells) farthest = std::max(farthest, cell.y);
  EXPECT_GE(farthest, 9);
  EXPECT_FALSE(find_route(costs, {5, 6}, {30, 3}));
}

TEST(PathSearch, ARobotTooNearToSomethingMayLeave) {
  GroundMap ground;
  ground.box = {0, 0, 40, 40};
  ground.classes.assign(ground.box.size(), ColumnClass::kFree);
  std::vector<std::uint8_t> occupied(ground.box.size(), 0);
  occupied[ground.box.index({10, 10})] = 1;
  ground.classes[ground.box.index({10, 10})] = ColumnClass::kOccupied;
  ground.to_obstacle_m = distance_to_marked_m(ground.box, occupied);
  CostGrid costs = route_costs(ground, 0.234, {});
  EXPECT_FALSE(find_route(costs, {12, 10}, {30, 10}));
  open_around(ground, centre_m({12, 10}), 0.35, costs);
  EXPECT_TRUE(find_route(costs, {12, 10}, {30, 10}));
  EXPECT_EQ(costs.at({10, 10}, 0), kImpassable);
}

/// In a passable cell, but for rounding.
bool near_passable(const CostGrid& costs, const Eigen::Vector2d& at_m) {
  for (const double dx : {-1e-7, 1e-7}) {
    for (const double dy : {-1e-7, 1e-7}) {
      if (costs.at(cell_at(at_m + Eigen::Vector2d(dx, dy)), kImpassable) < kImpassable) return true;
    }
  }
  return false;
}

TEST(PathSmoothing, AStraightWayCostsWhatItsCellsCost) {
  constexpr unsigned kSeed = 23;
  std::mt19937 random(kSeed);
  const CostGrid costs = random_costs(random, 30, 0);
  std::uniform_real_distribution<double> place(-0.7, 0.7);
  for (int round = 0; round < 200; ++round) {
    const Eigen::Vector2d a(place(random), place(random));
    const Eigen::Vector2d b(place(random), place(random));
    double sum = 0;
    constexpr int kSamples = 20000;
    for (int i = 0; i < kSamples; ++i)
      sum += static_cast<double>(costs.at(cell_at(a + (b - a) * (i + 0.5) / kSamples), 0));
    EXPECT_NEAR(straight_cost(costs, a, b), sum / kSamples * (b - a).norm(), 1e-3);
  }
}

TEST(PathSmoothing, KeepsToPassableCellsAndCostsLittleMore) {
  constexpr unsigned kSeed = 3;
  std::mt19937 random(kSeed);
  int smoothed = 0;
  for (int round = 0; round < 80; ++round) {
    CostGrid costs({0, 0, 50, 50}, 1);
    for (int k = 0; k < 12; ++k) {
      const auto x0 = static_cast<std::int32_t>(random() % 45);
      const auto y0 = static_cast<std::int32_t>(random() % 45);
      for (std::int32_t y = y0; y < y0 + 5; ++y) {
        for (std::int32_t x = x0; x < x0 + 5; ++x)
          costs.values[costs.box.index({x, y})] = kImpassable;
      }
    }
    const auto route = find_route(costs, {0, 0}, {49, 49});
    if (!route) continue;
    ++smoothed;
    const auto points = smooth_path(costs, route->cells);
    EXPECT_EQ(points.front(), centre_m({0, 0}));
    EXPECT_EQ(points.back(), centre_m({49, 49}));
    double length_m = 0;
    for (std::size_t i = 1; i < points.size(); ++i) {
      for (double share = 0; share <= 1; share += 0.05) {
        const Eigen::Vector2d at = points[i - 1] + share * (points[i] - points[i - 1]);
        ASSERT_TRUE(near_passable(costs, at)) << at.transpose();
      }
      EXPECT_LE((points[i] - points[i - 1]).norm(), kPointSpacing_m + 1e-9);
      length_m += (points[i] - points[i - 1]).norm();
    }
    EXPECT_LE(length_m, 1.03 * route->cost);
  }
  EXPECT_GT(smoothed, 40);
}

TEST(PathSmoothing, OnFreeGroundTheWayIsStraight) {
  const CostGrid costs({0, 0, 50, 50}, 1);
  const auto route = find_route(costs, {0, 0}, {40, 17});
  const auto points = smooth_path(costs, route->cells);
  double length_m = 0;
  for (std::size_t i = 1; i < points.size(); ++i) length_m += (points[i] - points[i - 1]).norm();
  EXPECT_NEAR(length_m, std::hypot(40, 17) * kCell_m, 1e-3);
}

TEST(DistanceTransform, IsThatOfBruteForce) {
  constexpr unsigned kSeed = 11;
  std::mt19937 random(kSeed);
  for (const unsigned every : {3U, 20U, 200U, 1000U}) {
    const CellBox box{-7, 4, 37, 23};
    std::vector<std::uint8_t> marked(box.size());
    for (std::uint8_t& mark : marked) mark = random() % every == 0 ? 1 : 0;
    const auto grid = distance_to_marked_m(box, marked);
    for (std::size_t i = 0; i < marked.size(); ++i) {
      double nearest_m = std::numeric_limits<double>::infinity();
      for (std::size_t j = 0; j < marked.size(); ++j) {
        if (marked[j] != 0)
          nearest_m = std::min(nearest_m, (centre_m(box.cell(i)) - centre_m(box.cell(j))).norm());
      }
      if (std::isinf(nearest_m)) {
        ASSERT_TRUE(std::isinf(grid.values[i]));
      } else {
        ASSERT_NEAR(grid.values[i], nearest_m, 1e-5);
      }
    }
  }
  EXPECT_TRUE(distance_to_marked_m({}, {}).values.empty());
}

}  // namespace
}  // namespace cairn::planning
