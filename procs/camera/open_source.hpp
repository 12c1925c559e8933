// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "bus/node.hpp"
#include "camera/frame_source.hpp"

namespace cairn {

struct CameraConfig;

/// The frame source that the config names. An error names the key that is missing or the file that
/// does not serve.
[[nodiscard]] Result<std::unique_ptr<camera::FrameSource>> open_source(const CameraConfig& config,
                                                                       const bus::Node& node);

}  // namespace cairn
