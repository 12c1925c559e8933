// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "core/config.hpp"
#include "planning/path_search.hpp"
#include "planning/pose2.hpp"
#include "planning/traversability.hpp"

namespace cairn::planning {

struct ExplorationConfig {
  double view_from_m = 0.7;
  double view_to_m = 2.4;
  double view_angle_deg = 50;
  double least_m2 = 0.1;
  double worth_s_per_m2 = 20;
  double cruise_mps = 0.35;
  double turn_radps = 0.7;

  void visit(ConfigVisitor& v) {
    v.number("view_from_m", view_from_m, {0, 5}, "m", "nearer floor is out of the cameras' sight");
    v.number("view_to_m", view_to_m, {0.2, 20}, "m", "farther floor is seen too coarsely to count");
    v.number("view_angle_deg", view_angle_deg, {10, 180}, "deg", "width of the view");
    v.number("least_m2", least_m2, {0, 10}, "m2",
             "a view that shows less unknown floor is not worth it");
    v.number("worth_s_per_m2", worth_s_per_m2, {0, 1000}, "s/m2",
             "how much longer a way may be for more unknown floor in view");
    v.number("cruise_mps", cruise_mps, {0.01, 5}, "m/s", "speed that ways are reckoned with");
    v.number("turn_radps", turn_radps, {0.05, 10}, "rad/s", "turn that ways are reckoned with");
  }
};

/// From where to look next.
struct Viewpoint {
  Pose2 pose;
  double gain_m2 = 0;  ///< unknown floor in view
};

/// Decides what is still worth looking at, and from where (next best view, Connolly 1985; Yamauchi
/// 1997 for frontiers). Wanted is ground that was not seen, no narrower than 15 cm, that the
/// robot's body could come to stand on if it turned out to be floor. What was looked at kMostLooks
/// times and stayed unknown is given up.
class Exploration {
 public:
  static constexpr int kMostLooks = 2;
  /// Views farther apart than this in angle are not told apart.
  static constexpr int kDirections = 72;

  explicit Exploration(const ExplorationConfig& config) : config_{config} {}

  /// Says what is wanted now, given where the robot can go.
  void update(const GroundMap& ground, const RouteField& routes, double turning_radius_m,
              double margin_m);

  /// The best place to look from; nothing if all views show less than least_m2.
  [[nodiscard]] std::optional<Viewpoint> choose(const GroundMap& ground, const RouteField& routes,
                                                const Pose2& robot) const;

  /// The place that is reached first from which a spot comes into view as a whole, nothing standing
  /// before it; nothing if there is none.
  [[nodiscard]] std::optional<Viewpoint> see_spot(const GroundMap& ground, const RouteField& routes,
                                                  const Pose2& robot,
                                                  const BlockedSpot& spot) const;

  /// Wanted floor in view from a pose [m2].
  [[nodiscard]] double gain_m2(const GroundMap& ground, const Pose2& from) const;

  /// Notes that what is wanted and in view was looked at in vain, `times` times.
  void give_up_in_view(const GroundMap& ground, const Pose2& from, int times);

  [[nodiscard]] bool wanted(Cell cell) const { return wanted_.at(cell, 0) != 0; }
  [[nodiscard]] double wanted_m2() const;
  /// Wanted floor that was given up [m2].
  [[nodiscard]] double given_up_m2() const { return given_up_m2_; }

  /// How often cells were looked at in vain; for checkpoints.
  [[nodiscard]] const std::map<Cell, std::uint8_t>& looks() const { return looks_; }
  void restore_looks(std::map<Cell, std::uint8_t> looks) { looks_ = std::move(looks); }

 private:
  template <class Visit>
  void cast(const GroundMap& ground, const Eigen::Vector2d& from_m, int direction,
            Visit&& visit) const;
  [[nodiscard]] double time_s(const RouteField& routes, const Pose2& robot, Cell cell,
                              double heading_rad) const;
  [[nodiscard]] int window() const;
  [[nodiscard]] int first_direction(double heading_rad) const;

  ExplorationConfig config_;
  CellGrid<std::uint8_t> wanted_;
  std::map<Cell, std::uint8_t> looks_;
  double given_up_m2_ = 0;
};

}  // namespace cairn::planning
