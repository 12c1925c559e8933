// SPDX-License-Identifier: Apache-2.0
#include "procs/simulator/frame_painter.hpp"

namespace cairn {

Result<stereo_frame_t> FramePainter::paint(const Capture& capture) {
  const auto pair = renderer_.render(capture.T_world_body, capture.index, capture.people);
  camera::Frame frame;
  frame.index = capture.index;
  frame.utime = capture.utime;
  frame.left = pair.left;
  frame.right = pair.right;
  return encoder_.encode(frame, calibration_id_);
}

}  // namespace cairn
