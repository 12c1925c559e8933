// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "camera/recording.hpp"

namespace cairn::camera {

/// A sequence of the KITTI odometry benchmark (Geiger et al. 2012): image_0, image_1, calib.txt
/// with P0 and P1, times.txt (else 10 Hz); truth in poses.txt here, or in ../../poses/NAME.txt as
/// the benchmark lays it out. The cameras stand 1.65 m above the street, and streets are mapped at
/// 0.2 m as far as 30 m.
[[nodiscard]] Result<Recording> find_kitti_recording(const std::filesystem::path& folder);

}  // namespace cairn::camera
