// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/result.hpp"
#include "planning/cell_grid.hpp"
#include "planning/traversability.hpp"

namespace cairn::planning {

/// What the robot was told to do.
enum class Mission : std::uint8_t { kNone = 0, kGo = 1, kExplore = 2 };

/// How it stands with it.
enum class Phase : std::uint8_t {
  kIdle = 0,
  kDriving = 1,
  kExploring = 2,
  kRecovering = 3,
  kArrived = 4,
  kRefused = 5,
};

/// A place to go to, in the map.
struct Destination {
  Eigen::Vector2d at_m = Eigen::Vector2d::Zero();
  std::optional<double> heading_rad;
};

/// What must outlive a restart.
struct PlanMemory {
  Mission mission = Mission::kNone;
  std::int64_t goal_id = 0;
  Destination destination;
  bool looked_round = false;
  Phase phase = Phase::kIdle;
  std::string reason;
  std::vector<KnownFloor> floor;
  std::map<Cell, std::uint8_t> looks;
};

/// Little end first.
[[nodiscard]] std::vector<std::uint8_t> to_bytes(const PlanMemory& memory);

/// An error names what is wrong: too short or too long, a wrong magic word, a number that is not
/// finite or out of range.
[[nodiscard]] Result<PlanMemory> plan_memory_from_bytes(std::span<const std::uint8_t> bytes);

}  // namespace cairn::planning
