// SPDX-License-Identifier: Apache-2.0
// planner: where to go, and how to move now.
// in: POSE, ODOMETRY, MAP_DELTA, MAP_DIGEST, WHEEL_STATE, CLEARANCE, GOAL
// out: DRIVE_COMMAND, PATH, PLAN_STATE, MAP_REQUEST
#include "bus/process.hpp"
#include "procs/planner/planner_node.hpp"

int main(int argc, char** argv) { return cairn::bus::run_process<cairn::PlannerNode>(argc, argv); }
