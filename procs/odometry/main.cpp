// SPDX-License-Identifier: Apache-2.0
// odometry: how the robot moves, by its eyes and its tracks.
// in: STEREO_FRAME, WHEEL_STATE, CALIBRATION   out: ODOMETRY
#include "bus/process.hpp"
#include "procs/odometry/odometry_node.hpp"

int main(int argc, char** argv) { return cairn::bus::run_process<cairn::OdometryNode>(argc, argv); }
