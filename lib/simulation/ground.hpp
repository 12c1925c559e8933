// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "core/geometry.hpp"
#include "simulation/world.hpp"

namespace cairn::simulation {

/// What a robot may stand on: surfaces that face up, sloped by at most this.
inline constexpr double kSteepestGround_rad = 0.2618;  // 15 degrees

/// Height of the highest ground at (x, y) that is not above `limit_m`; nothing where there is none.
[[nodiscard]] std::optional<double> ground_height_m(std::span<const Box* const> boxes,
                                                    const Eigen::Vector2d& at, double limit_m);

/// Where two tracks touch the ground.
struct TrackPlan {
  double length_m = 0;  ///< of each track's contact line, the body frame in its middle
  double gauge_m = 0;
  double step_m = 0;  ///< ground this much above or below the plane of the tracks is no support
};

/// How a body stands.
struct Stance {
  Isometry T_world_body = Isometry::Identity();
  bool tipped = false;  ///< nothing carries it before or behind its middle: it fell
};

/// The stance of a body at (x, y) that heads along yaw, near the stance it had: the plane that fits
/// the ground under the tracks best, lifted until nothing of it is in the ground. Ground that lies
/// too low to carry a track is bridged as long as what is left carries the body's middle; else the
/// body falls on it. Where there is no ground at all it hangs where it was.
[[nodiscard]] Stance stand_on(std::span<const Box* const> boxes, const TrackPlan& tracks,
                              const Isometry& before, const Eigen::Vector2d& at, double yaw);

}  // namespace cairn::simulation
