// SPDX-License-Identifier: Apache-2.0
// odometry: how the robot moves, by what it sees.
// in: STEREO_FRAME, CALIBRATION   out: ODOMETRY
#include "bus/process.hpp"
#include "procs/odometry/odometry_node.hpp"

int main(int argc, char** argv) { return cairn::bus::run_process<cairn::OdometryNode>(argc, argv); }
