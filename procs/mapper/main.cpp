// SPDX-License-Identifier: Apache-2.0
// mapper: what is where.
// in: DISPARITY and POSE (or ODOMETRY) joined by utime, MAP_COMMAND   out: MAP_DELTA, and map.cairn
// in its state folder
#include "bus/process.hpp"
#include "procs/mapper/mapper_node.hpp"

int main(int argc, char** argv) { return cairn::bus::run_process<cairn::MapperNode>(argc, argv); }
