// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cairn/stereo_frame_t.hpp>
#include <cstdint>
#include <utility>

#include "camera/rig_calibration.hpp"
#include "core/result.hpp"
#include "messages/image_messages.hpp"
#include "procs/simulator/capture.hpp"
#include "simulation/renderer.hpp"

namespace cairn {

/// What the two cameras saw, as it goes over the bus. What it gives depends on nothing but the
/// sequence of captures.
class FramePainter {
 public:
  FramePainter(simulation::Renderer renderer, std::uint64_t calibration_id, int budget_bytes)
      : renderer_{std::move(renderer)},
        encoder_{messages::ImageEncoding::kJpeg, budget_bytes},
        calibration_id_{calibration_id} {}

  [[nodiscard]] Result<stereo_frame_t> paint(const Capture& capture);

 private:
  simulation::Renderer renderer_;
  messages::FrameEncoder encoder_;
  std::uint64_t calibration_id_;
};

}  // namespace cairn
