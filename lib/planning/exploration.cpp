// SPDX-License-Identifier: Apache-2.0
#include "planning/exploration.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "planning/distance_transform.hpp"

namespace cairn::planning {
namespace {

constexpr double kStride_m = kCell_m;
constexpr double kSeesOver_m = 0.4;   // of unknown ground, before a ray tells nothing any more
constexpr std::int32_t kLattice = 3;  // cells between the places that are tried
constexpr double kStanding_m = 0.2;   // floor must be known this far around a place
constexpr double kAside = 0.3;        // what lies at the view's edge counts less by so much
constexpr double kEnough_m2 = 1.5;
constexpr double kWideTurn_rad = 1.2;
constexpr double kWideTurnCost_s = 3;  // guard lets the robot creep onto what it has not seen yet
constexpr double kSteering = 0.5;      // share of a turn's time that an arc costs

double direction_rad(int direction) {
  return 2 * std::numbers::pi * direction / Exploration::kDirections;
}

/// Cells that are no wall as far as is known, with room for the robot, joined to where it can go.
std::vector<std::uint8_t> could_stand(const GroundMap& ground, const RouteField& routes,
                                      double room_m) {
  std::vector<std::uint8_t> stands(ground.classes.size(), 0);
  std::vector<Cell> queue;
  for (std::size_t i = 0; i < stands.size(); ++i) {
    if (routes.cost[i] == kImpassable) continue;
    stands[i] = 1;
    queue.push_back(ground.box.cell(i));
  }
  for (std::size_t at = 0; at < queue.size(); ++at) {
    for (const CellStep step : kFourSteps) {
      const Cell to = queue[at] + step;
      if (!ground.box.contains(to)) continue;
      const std::size_t j = ground.box.index(to);
      if (stands[j] != 0 || ground.reached[j] == 0 || ground.classes[j] == ColumnClass::kOccupied ||
          ground.to_obstacle_m.values[j] < room_m) {
        continue;
      }
      stands[j] = 1;
      queue.push_back(to);
    }
  }
  return stands;
}

/// Cells that were not seen and belong to a square of three by three such ones.
std::vector<std::uint8_t> broad_unseen(const GroundMap& ground) {
  const CellBox& box = ground.box;
  std::vector<std::uint8_t> broad(ground.classes.size(), 0);
  const auto row = static_cast<std::size_t>(box.width);
  for (std::int32_t y = 1; y + 1 < box.height; ++y) {
    for (std::int32_t x = 1; x + 1 < box.width; ++x) {
      const std::size_t middle = static_cast<std::size_t>(y) * row + static_cast<std::size_t>(x);
      bool all = true;
      for (std::size_t i = middle - row - 1; all && i <= middle + row - 1; i += row) {
        for (std::size_t j = i; all && j < i + 3; ++j) {
          all = ground.classes[j] == ColumnClass::kUnknown || ground.assumed[j] != 0;
        }
      }
      if (!all) continue;
      for (std::size_t i = middle - row - 1; i <= middle + row - 1; i += row) {
        std::fill_n(broad.begin() + static_cast<std::ptrdiff_t>(i), 3, std::uint8_t{1});
      }
    }
  }
  return broad;
}

}  // namespace

void Exploration::update(const GroundMap& ground, const RouteField& routes, double turning_radius_m,
                         double margin_m) {
  const auto stands = could_stand(ground, routes, turning_radius_m + margin_m);
  const auto to_standing_m = distance_to_marked_m(ground.box, stands);
  const auto broad = broad_unseen(ground);
  wanted_ = CellGrid<std::uint8_t>(ground.box, 0);
  for (std::size_t i = 0; i < broad.size(); ++i) {
    wanted_.values[i] = broad[i] != 0 && ground.reached[i] != 0 &&
                        to_standing_m.values[i] <= static_cast<float>(turning_radius_m);
  }
  given_up_m2_ = 0;
  for (const auto& [cell, looks] : looks_) {
    if (looks < kMostLooks || !wanted(cell)) continue;
    wanted_.values[wanted_.box.index(cell)] = 0;
    given_up_m2_ += kCell_m * kCell_m;
  }
}

/// Calls visit(cell, distance_m) along a direction, until something is in the way.
template <class Visit>
void Exploration::cast(const GroundMap& ground, const Eigen::Vector2d& from_m, int direction,
                       Visit&& visit) const {
  const double angle = direction_rad(direction);
  const Eigen::Vector2d stride = kStride_m * Eigen::Vector2d(std::cos(angle), std::sin(angle));
  Eigen::Vector2d at = from_m;
  double unknown_m = 0;
  for (double r = kStride_m; r <= config_.view_to_m; r += kStride_m) {
    at += stride;
    const Cell cell = cell_at(at);
    if (!ground.box.contains(cell)) return;
    const std::size_t i = ground.box.index(cell);
    if (ground.classes[i] == ColumnClass::kOccupied) return;
    if (ground.classes[i] == ColumnClass::kUnknown) {
      unknown_m += kStride_m;
      if (ground.reached[i] == 0 || unknown_m > kSeesOver_m) return;
    }
    if (r >= config_.view_from_m && wanted(cell)) visit(cell, r);
  }
}

int Exploration::window() const {
  return std::max(1, static_cast<int>(config_.view_angle_deg / 360 * kDirections));
}

int Exploration::first_direction(double heading_rad) const {
  return static_cast<int>(std::lround(heading_rad / direction_rad(1) - 0.5 * (window() - 1)));
}

double Exploration::time_s(const RouteField& routes, const Pose2& robot, Cell cell,
                           double heading_rad) const {
  const double drive_s = routes.cost[routes.box.index(cell)] / config_.cruise_mps;
  const Eigen::Vector2d way = centre_m(cell) - robot.at_m;
  double arrival_rad = robot.heading_rad;
  double start_s = 0;
  if (way.norm() > 2 * kCell_m) {
    arrival_rad = std::atan2(way.y(), way.x());
    const double turn_rad = std::abs(wrapped_rad(arrival_rad - robot.heading_rad));
    start_s = turn_rad > kWideTurn_rad ? kWideTurnCost_s + turn_rad / config_.turn_radps
                                       : kSteering * turn_rad / config_.turn_radps;
  }
  return drive_s + start_s + std::abs(wrapped_rad(heading_rad - arrival_rad)) / config_.turn_radps;
}

std::optional<Viewpoint> Exploration::choose(const GroundMap& ground, const RouteField& routes,
                                             const Pose2& robot) const {
  std::optional<Viewpoint> best;
  double best_score = 0;
  const int width = window();
  const double ray_rad = direction_rad(1);
  const CellGrid<float> to_wanted_m = distance_to_marked_m(ground.box, wanted_.values);
  const auto consider = [&](Cell cell) {
    if (!routes.reaches(cell) || to_wanted_m.at(cell, kImpassable) > config_.view_to_m) return;
    for (const CellStep step : kEightSteps) {
      const auto ring = static_cast<std::int32_t>(kStanding_m / kCell_m);
      if (ground.at({cell.x + ring * step.x, cell.y + ring * step.y}) == ColumnClass::kUnknown)
        return;
    }
    std::array<double, kDirections> gains{};
    for (int d = 0; d < kDirections; ++d) {
      cast(ground, centre_m(cell), d,
           [&](Cell, double r) { gains[static_cast<std::size_t>(d)] += r * ray_rad * kStride_m; });
    }
    for (int d = 0; d < kDirections; ++d) {
      double gain = 0;
      double aimed = 0;
      for (int k = 0; k < width; ++k) {
        const double seen = gains[static_cast<std::size_t>((d + k) % kDirections)];
        gain += seen;
        aimed += seen * (1 - kAside * std::abs(2.0 * k / std::max(1, width - 1) - 1));
      }
      if (gain < config_.least_m2) continue;
      const double heading_rad = wrapped_rad(direction_rad(d) + 0.5 * (width - 1) * ray_rad);
      const double score = time_s(routes, robot, cell, heading_rad) -
                           config_.worth_s_per_m2 * std::min(aimed, kEnough_m2);
      if (best && score >= best_score) continue;
      best = Viewpoint{{centre_m(cell), heading_rad}, gain};
      best_score = score;
    }
  };
  const CellBox& box = ground.box;
  for (std::int32_t y = box.y0; y < box.y0 + box.height; y += kLattice) {
    for (std::int32_t x = box.x0; x < box.x0 + box.width; x += kLattice) consider({x, y});
  }
  consider(routes.from);
  return best;
}

std::optional<Viewpoint> Exploration::see_spot(const GroundMap& ground, const RouteField& routes,
                                               const Pose2& robot, const BlockedSpot& spot) const {
  std::optional<Viewpoint> best;
  double best_s = 0;
  const double nearest_m = config_.view_from_m + spot.radius_m;
  const CellBox& box = ground.box;
  for (std::int32_t y = box.y0; y < box.y0 + box.height; y += kLattice) {
    for (std::int32_t x = box.x0; x < box.x0 + box.width; x += kLattice) {
      const Cell cell{x, y};
      const Eigen::Vector2d way = spot.at_m - centre_m(cell);
      const double distance_m = way.norm();
      if (!routes.reaches(cell) || distance_m < nearest_m || distance_m > config_.view_to_m)
        continue;
      const double heading_rad = std::atan2(way.y(), way.x());
      const double needed_s = time_s(routes, robot, cell, heading_rad);
      if (best && needed_s >= best_s) continue;
      bool free = true;
      for (double r = kStride_m; free && r < distance_m - spot.radius_m; r += kStride_m)
        free = ground.at(cell_at(centre_m(cell) + r / distance_m * way)) != ColumnClass::kOccupied;
      if (!free) continue;
      best = Viewpoint{{centre_m(cell), heading_rad}, 0};
      best_s = needed_s;
    }
  }
  return best;
}

double Exploration::gain_m2(const GroundMap& ground, const Pose2& from) const {
  double gain = 0;
  const int width = window();
  const int first = first_direction(from.heading_rad);
  for (int k = 0; k < width; ++k) {
    cast(ground, from.at_m, first + k,
         [&](Cell, double r) { gain += r * direction_rad(1) * kStride_m; });
  }
  return gain;
}

void Exploration::give_up_in_view(const GroundMap& ground, const Pose2& from, int times) {
  std::set<Cell> seen;
  const int width = window();
  const int first = first_direction(from.heading_rad);
  for (int k = 0; k < width; ++k) {
    cast(ground, from.at_m, first + k, [&](Cell cell, double) {
      seen.insert(cell);
      for (const CellStep step : kEightSteps) {
        if (wanted(cell + step)) seen.insert(cell + step);
      }
    });
  }
  for (const Cell& cell : seen) {
    std::uint8_t& looks = looks_[cell];
    looks = static_cast<std::uint8_t>(std::min(kMostLooks, looks + times));
    if (looks == kMostLooks) wanted_.values[wanted_.box.index(cell)] = 0;
  }
}

double Exploration::wanted_m2() const {
  const auto count = std::count(wanted_.values.begin(), wanted_.values.end(), std::uint8_t{1});
  return static_cast<double>(count) * kCell_m * kCell_m;
}

}  // namespace cairn::planning
