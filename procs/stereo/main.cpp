// SPDX-License-Identifier: Apache-2.0
// stereo: depth from two images.
// in: STEREO_FRAME, CALIBRATION   out: DISPARITY
#include "bus/process.hpp"
#include "procs/stereo/stereo_node.hpp"

int main(int argc, char** argv) { return cairn::bus::run_process<cairn::StereoNode>(argc, argv); }
