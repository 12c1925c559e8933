// SPDX-License-Identifier: Apache-2.0
// localizer: where the robot is in the map.
// in: ODOMETRY, DISPARITY joined with it by utime, MAP_DELTA, MAP_DIGEST, LOCALIZER_COMMAND
// out: POSE, PARTICLES, MAP_REQUEST
#include "bus/process.hpp"
#include "procs/localizer/localizer_node.hpp"

int main(int argc, char** argv) {
  return cairn::bus::run_process<cairn::LocalizerNode>(argc, argv);
}
