// SPDX-License-Identifier: Apache-2.0
// motor: the wheels, and whether they may turn.
// in: DRIVE_COMMAND, CLEARANCE, STOP, CLOCK   out: WHEEL_STATE
#include "bus/process.hpp"
#include "procs/motor/motor_node.hpp"

int main(int argc, char** argv) { return cairn::bus::run_process<cairn::MotorNode>(argc, argv); }
