// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>
#include <vector>

namespace cairn::odometry {

/// Adds corners (Shi and Tomasi 1994) to `taken` until about `target` are spread over the image:
/// the image is cut into cells that may hold four each, so that a rich corner of the scene does not
/// get all. None lies nearer than `min_distance_px` to another or `margin_px` to the border.
/// Returns the new ones alone, at whole pixels, cell by cell, strongest first.
[[nodiscard]] std::vector<cv::Point2f> spread_corners(const cv::Mat& image,
                                                      const std::vector<cv::Point2f>& taken,
                                                      int target, int min_distance_px,
                                                      int margin_px);

}  // namespace cairn::odometry
