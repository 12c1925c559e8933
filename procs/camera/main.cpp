// SPDX-License-Identifier: Apache-2.0
// camera: what the two eyes see.
// in: nothing   out: STEREO_FRAME (of a depth recording: DISPARITY), CALIBRATION, CLOCK
#include "bus/process.hpp"
#include "procs/camera/camera_node.hpp"

int main(int argc, char** argv) { return cairn::bus::run_process<cairn::CameraNode>(argc, argv); }
