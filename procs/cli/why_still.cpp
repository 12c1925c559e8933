// SPDX-License-Identifier: Apache-2.0
#include "procs/cli/why_still.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace cairn::cli {
namespace {

/// Slower is standing.
constexpr double kStanding_mps = 0.005;

std::string speed_text(double speed_mps) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.2f m/s", speed_mps);
  return text;
}

std::string why(const std::string& reason) { return reason.empty() ? "" : ": " + reason; }

/// What keeps the planner from driving; empty: nothing.
std::string of_planner(const MotionHeard& heard) {
  if (heard.pose && heard.pose->state == pose_t::STATE_LOST) {
    return "lost: the localizer does not know where the robot is";
  }
  if (heard.pose && heard.pose->state == pose_t::STATE_AMBIGUOUS) {
    return "lost: several places look like where the robot is";
  }
  if (!heard.plan) return "";
  switch (heard.plan->state) {
    case plan_state_t::STATE_IDLE:
      return "idle: planner has nothing to do" + why(heard.plan->reason);
    case plan_state_t::STATE_ARRIVED:
      return "idle: planner has arrived" + why(heard.plan->reason);
    case plan_state_t::STATE_REFUSED:
      return "idle: planner refused the goal" + why(heard.plan->reason);
    default:
      return "";
  }
}

std::string of_guard(const MotionHeard& heard) {
  if (!heard.clearance) return "no clearance: guard is not heard";
  if (heard.clearance->max_forward_mps > 0) return "";
  return "no clearance" + why(heard.clearance->reason);
}

std::string reason_to_stand(const MotionHeard& heard) {
  constexpr std::int32_t kNoController = 1;
  if (!heard.wheels) return "no wheels: motor is not heard";
  if (heard.wheels->gate == wheel_state_t::GATE_LATCHED) {
    return "latched: somebody stopped the robot; ./cairn release ends it";
  }
  if ((heard.wheels->faults & kNoController) != 0) return "no wheels: motor has no controller";
  const std::string planner = of_planner(heard);
  if (heard.wheels->gate == wheel_state_t::GATE_IDLE) {
    return planner.empty() ? "idle: nobody tells it to move" : planner;
  }
  const std::string guard = of_guard(heard);
  if (!guard.empty()) return guard;
  return planner.empty() ? "driving: zero is commanded" : planner;
}

}  // namespace

Motion describe_motion(const MotionHeard& heard) {
  if (heard.wheels) {
    const double left_mps = heard.wheels->left_measured_mps;
    const double right_mps = heard.wheels->right_measured_mps;
    if (std::max(std::abs(left_mps), std::abs(right_mps)) > kStanding_mps) {
      return {true, "moves: " + speed_text(0.5 * (left_mps + right_mps)) + ", tracks " +
                        speed_text(left_mps) + " and " + speed_text(right_mps)};
    }
  }
  return {false, "holds still: " + reason_to_stand(heard)};
}

}  // namespace cairn::cli
