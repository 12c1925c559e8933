// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "planning/pose2.hpp"
#include "planning/traversability.hpp"

namespace cairn::planning {

/// Where the robot stood and drove, in the map: floor though no camera saw it, and the way back.
class Trail {
 public:
  static constexpr double kSpacing_m = 0.1;
  /// Longer trails lose their oldest tenth, except where the robot was put down.
  static constexpr std::size_t kLongest = 20'000;

  /// track_radius_m: half of the width that the body sweeps; stand_radius_m: of the disc around a
  /// place where it was put down, which its cameras cannot see.
  Trail(double track_radius_m, double stand_radius_m)
      : track_radius_m_{track_radius_m}, stand_radius_m_{stand_radius_m} {}

  /// The robot was put down here.
  void stand(const Eigen::Vector2d& at_m, double height_m);
  /// It is here now; true if that made the trail longer.
  bool drive(const Eigen::Vector2d& at_m, double height_m);
  void clear() { floor_.clear(); }

  /// The way that it came, from here backwards for at most this long.
  [[nodiscard]] std::vector<Eigen::Vector2d> way_back_m(double length_m) const;

  /// In the order of driving.
  [[nodiscard]] const std::vector<KnownFloor>& floor() const { return floor_; }
  void restore(std::vector<KnownFloor> floor) { floor_ = std::move(floor); }

 private:
  double track_radius_m_;
  double stand_radius_m_;
  std::vector<KnownFloor> floor_;
};

}  // namespace cairn::planning
