// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>

#include "core/result.hpp"
#include "core/time.hpp"
#include "stereo/disparity_image.hpp"

namespace cairn::stereo {

/// What a stereo pair of this camera would have measured where a depth sensor saw `depth_m`
/// (CV_32FC1 [m], of the camera's full size, 0 or not finite = no answer): disparity = f b / depth
/// - doffs at every step_px-th pixel, rounded to 1/16 px. The rounding alone moves a depth by up to
/// depth^2 / (32 f b). No answer gives kNoData; a disparity that rounds to 0 or below, or does not
/// fit, gives kOutOfRange. Confidence is 3 throughout.
[[nodiscard]] Result<DisparityImage> disparity_from_depth(const cv::Mat& depth_m,
                                                          const RectifiedCamera& camera,
                                                          int step_px, Utime utime);

}  // namespace cairn::stereo
