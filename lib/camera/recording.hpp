// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "camera/file_list.hpp"
#include "camera/frame_source.hpp"

namespace cairn::camera {

/// A recording of image files, whichever form it was found in: left and right, or depth alone.
struct Recording {
  FileList left;
  FileList right;
  FileList depth;
  double depth_scale_m = 0;        ///< metres per unit of a depth image
  std::vector<int> invalid_depth;  ///< values of a depth image that mean no answer
  std::vector<Utime> utimes;       ///< one per frame, rising
  double rate_hz = 0;
  RigCalibration rig;  ///< width_px 0: the size is that of the images
  DatasetInfo info;
};

/// Checks counts and rig, takes the size from the first image that can be read if the rig does not
/// say it, and makes the source of frames.
[[nodiscard]] Result<Dataset> open_recording(Recording recording);

}  // namespace cairn::camera
