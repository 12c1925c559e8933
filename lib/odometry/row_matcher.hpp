// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>
#include <optional>

namespace cairn::odometry {

struct RowMatch {
  double disparity_px = 0;
  double score = 0;  ///< normalised cross-correlation, at most 1
};

/// Finds where points of the left image lie on the same row of the right one: normalised
/// cross-correlation of 11x11 windows at whole disparities, then a sub-pixel fit of the disparity
/// to the grey values (Lucas and Kanade 1981, in one dimension, with gain and offset free). The
/// images must outlive the matcher.
class RowMatcher {
 public:
  /// Both CV_8UC1 and of one size.
  RowMatcher(const cv::Mat& left, const cv::Mat& right) : left_{left}, right_{right} {}

  /// The match of (u_px, v_px), sub-pixel, with a disparity within [min_disparity_px,
  /// max_disparity_px]; nothing if the window is plain or leaves an image, the best correlation is
  /// below 0.8, or another disparity, 3 px or more off, is as good within 0.05.
  [[nodiscard]] std::optional<RowMatch> match(double u_px, double v_px, double min_disparity_px,
                                              double max_disparity_px) const;

  /// match, and the same from right to left must come back within 0.5 px.
  [[nodiscard]] std::optional<RowMatch> match_both_ways(double u_px, double v_px,
                                                        double min_disparity_px,
                                                        double max_disparity_px) const;

 private:
  const cv::Mat& left_;
  const cv::Mat& right_;
};

}  // namespace cairn::odometry
