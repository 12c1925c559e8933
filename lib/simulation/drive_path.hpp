// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "core/geometry.hpp"
#include "evaluation/trajectory.hpp"

namespace cairn::simulation {

/// How a scripted robot drives.
struct DriveConfig {
  double speed_mps = 0.85;
  double acceleration_mps2 = 1.0;
  double rate_hz = 15;
};

/// Poses T_world_body of a robot on the floor (z = 0) that drives once round a closed smooth curve
/// through the waypoints (Catmull and Rom 1974), looking along it; it starts and ends standing at
/// the first one. Pose i is of the time i / rate_hz. At least three waypoints, no two neighbours
/// alike.
[[nodiscard]] evaluation::Trajectory drive_round(std::span<const Eigen::Vector2d> waypoints_m,
                                                 const DriveConfig& config);

/// A way round the middle of config/worlds/room.yaml, some 6.5 m long.
[[nodiscard]] std::vector<Eigen::Vector2d> room_tour_m();

}  // namespace cairn::simulation
