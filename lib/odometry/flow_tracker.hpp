// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>
#include <vector>

namespace cairn::odometry {

/// An image at full, half, quarter ... size, ready for tracking.
using Pyramid = std::vector<cv::Mat>;

[[nodiscard]] Pyramid make_pyramid(const cv::Mat& image);

struct FlowPoint {
  cv::Point2f at_px;
  bool found = false;
};

/// Follows points from one image to another (pyramidal Lucas and Kanade: Bouguet 2000), from where
/// they are expected, and back again; a point counts as found if the way back ends within 0.5 px of
/// where it began.
[[nodiscard]] std::vector<FlowPoint> track(const Pyramid& from, const Pyramid& to,
                                           const std::vector<cv::Point2f>& points_px,
                                           const std::vector<cv::Point2f>& expected_px);

}  // namespace cairn::odometry
