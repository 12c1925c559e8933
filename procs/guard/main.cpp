// SPDX-License-Identifier: Apache-2.0
// guard: how fast the robot may move forward, by what it sees before it.
// in: DISPARITY, WHEEL_STATE, RANGE   out: CLEARANCE
#include "bus/process.hpp"
#include "procs/guard/guard_node.hpp"

int main(int argc, char** argv) { return cairn::bus::run_process<cairn::GuardNode>(argc, argv); }
