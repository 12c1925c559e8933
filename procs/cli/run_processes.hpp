// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/result.hpp"
#include "procs/camera/camera_node.hpp"
#include "procs/guard/guard_node.hpp"
#include "procs/localizer/localizer_node.hpp"
#include "procs/mapper/mapper_node.hpp"
#include "procs/motor/motor_node.hpp"
#include "procs/odometry/odometry_node.hpp"
#include "procs/planner/planner_node.hpp"
#include "procs/simulator/simulator_node.hpp"
#include "procs/stereo/stereo_node.hpp"

namespace cairn::cli {

/// Calls `visit.operator()<ProcessNode>()` for each process that a run may have, until one fails.
template <class Visit>
[[nodiscard]] Result<void> for_each_process(Visit&& visit) {
  Result<void> result;
  const auto go_on = [&]<class ProcessNode>() {
    result = visit.template operator()<ProcessNode>();
    return result.has_value();
  };
  (void)(go_on.template operator()<CameraNode>() && go_on.template operator()<StereoNode>() &&
         go_on.template operator()<OdometryNode>() && go_on.template operator()<LocalizerNode>() &&
         go_on.template operator()<MapperNode>() && go_on.template operator()<PlannerNode>() &&
         go_on.template operator()<GuardNode>() && go_on.template operator()<MotorNode>() &&
         go_on.template operator()<SimulatorNode>());
  return result;
}

}  // namespace cairn::cli
