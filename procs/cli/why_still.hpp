// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cairn/clearance_t.hpp>
#include <cairn/plan_state_t.hpp>
#include <cairn/pose_t.hpp>
#include <cairn/wheel_state_t.hpp>
#include <optional>
#include <string>

namespace cairn::cli {

/// What was heard within the last second of what decides whether a robot moves.
struct MotionHeard {
  std::optional<wheel_state_t> wheels;
  std::optional<clearance_t> clearance;
  std::optional<pose_t> pose;
  std::optional<plan_state_t> plan;
};

/// Whether the tracks turn, or the first reason why not, in one line: "moves: 0.31 m/s",
/// "holds still: latched; ./cairn release ends it".
struct Motion {
  bool moves = false;
  std::string text;
};
[[nodiscard]] Motion describe_motion(const MotionHeard& heard);

}  // namespace cairn::cli
