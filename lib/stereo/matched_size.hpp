// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>

#include "core/result.hpp"
#include "core/time.hpp"
#include "stereo/disparity_image.hpp"
#include "stereo/matcher.hpp"
#include "stereo/pixel_grading.hpp"

namespace cairn::stereo {

/// An error unless both images are CV_8UC1, of the camera's size and at least `min_side_px` high
/// and wide.
[[nodiscard]] Result<void> check_pair(const cv::Mat& left, const cv::Mat& right,
                                      const RectifiedCamera& camera, int min_side_px);

/// The image as config.downscale says it is matched: itself, or the mean of each 2x2 pixels, where
/// an odd last row or column counts twice.
[[nodiscard]] cv::Mat at_matched_size(const cv::Mat& image, const MatcherConfig& config);

/// What was found at the size matched at, as the grid and camera that Matcher::match promises.
[[nodiscard]] DisparityImage on_grid(const GradedPixels& graded, const MatcherConfig& config,
                                     const RectifiedCamera& camera, Utime utime);

}  // namespace cairn::stereo
