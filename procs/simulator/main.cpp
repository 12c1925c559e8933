// SPDX-License-Identifier: Apache-2.0
// simulator: a place, a robot in it, its cameras and its wheel controller.
// in: the wheel line; at over life's speed DISPARITY, POSE, MAP_DELTA
// out: STEREO_FRAME (fast: DISPARITY, ODOMETRY), CALIBRATION, CLOCK, TRUTH, SIM_STATE; the wheel
// line
#include "bus/process.hpp"
#include "procs/simulator/simulator_node.hpp"

int main(int argc, char** argv) {
  return cairn::bus::run_process<cairn::SimulatorNode>(argc, argv);
}
