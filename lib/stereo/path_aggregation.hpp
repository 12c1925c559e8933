// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <opencv2/core.hpp>

#include "stereo/pixel_grading.hpp"

namespace cairn::stereo {

/// What it costs along a path that the disparity changes from one pixel to the next.
struct Penalties {
  int by_one_along_row = 14;
  int by_one_across_rows = 14;
  int by_more_at_least = 32;  ///< where grey changes much too
  int by_more_at_most = 80;   ///< where grey does not change
  int by_more_per_grey = 1;   ///< how fast it falls from the one to the other
};

/// For each pixel of the left image the disparity that the paths agree on best; all images are
/// CV_8UC1 of its size. Support counts for a disparity: the sum over the paths of how much cheaper
/// it is than the dearest that is not cut off.
struct Winners {
  cv::Mat_<std::uint8_t> index;      ///< disparity less the least one searched [px]
  cv::Mat_<std::uint8_t> support;    ///< of the winner
  cv::Mat_<std::uint8_t> below;      ///< of the disparity one less; 0 if not searched
  cv::Mat_<std::uint8_t> above;      ///< of the disparity one more; 0 if not searched
  cv::Mat_<std::uint8_t> runner_up;  ///< best of those more than 1 px from the winner
  /// At column x: the best support that the right image's pixel x - range.min_px has from any left
  /// pixel.
  cv::Mat_<std::uint8_t> right_support;

  void create(cv::Size size);
};

/// Semi-global matching (Hirschmueller 2008) along three paths per pixel: from the left, from the
/// right, and from the nearer of the top and bottom edges: the image is worked on from both edges
/// towards its middle row, on `threads` (1 or 2) threads; the result is the same for both. Cost as
/// in census.hpp, in saturating 8-bit lanes as by Spangenberg et al. (2014).
///
/// With C the cost, P1 and P2 the penalties, and V_r(p, d) what path r hands from pixel p on, the
/// recursion is
///   L_r(p, d) = C(p, d) - max(V(q, d), V(q, d - 1) - P1, V(q, d + 1) - P1, 0), q before p,
///   V_r(p, d) = max(min_i L_r(p, i) + P2(p, next) - L_r(p, d), 0),
/// which is the usual one with V = P2 - (L - min L): the cut at P2 is the jump. Support is the sum
/// of the three V.
///
/// Images CV_8UC1 of one size, not empty; at most 256 disparities. Columns beyond the right image's
/// left edge repeat its first.
void aggregate_paths(const cv::Mat& left, const cv::Mat& right, const SearchRange& range,
                     const Penalties& penalties, int threads, Winners& winners);

}  // namespace cairn::stereo
