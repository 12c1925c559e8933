// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>

namespace cairn::stereo {

/// Disparities min_px to below end_px are searched [px of the size matched at].
struct SearchRange {
  int min_px = 0;
  int end_px = 0;
};

struct GradedPixels {
  cv::Mat_<std::uint16_t> disparity_16ths;  ///< 1/16 px of the size matched at; 0 = no answer
  cv::Mat_<std::uint8_t> code;              ///< confidence or Reason, as in DisparityImage
};

/// Takes what must not be trusted out of a matcher's raw answers, and says of each pixel how good
/// it is or why there is nothing. `left` is CV_8UC1; `raw_16ths` holds 1/16 px, anything below
/// range.min_px * 16 meaning no answer.
///
/// No answer, first that applies: kNoData where every disparity searched, or the one found, points
/// beyond the right image's left edge, or where the answer was an island of at most
/// `speckle_size_px` pixels (neighbours within `speckle_range_px`); kOutOfRange where the best
/// disparity is the first or the last one searched, so that the true one may lie beyond;
/// kLowTexture where the mean absolute horizontal gradient over 9x9 is below 1 grey level per px;
/// kNoData where the disparity of the background beside it leads beyond that edge, or to a pixel of
/// the right image that something nearer has taken (covered there); else kAmbiguous: the matcher's
/// uniqueness or left-right check failed.
///
/// `confidence` (0 to 3 per pixel) is what the matcher itself knows of its answers. Where it is
/// empty, confidence says how far around the pixel the answers form one smooth surface, of whatever
/// slope: 1, 2, 3 for 2, 4 and 8 px, tested along row, column and diagonals (the mean of the two
/// answers that far off is within 0.5 px of the pixel's own). Then it is 0 where a pixel with a
/// disparity larger by over 1 px claims the same pixel of the right image, and 1 at most where the
/// gradient (as above) is below 1 grey level per px.
[[nodiscard]] GradedPixels grade_pixels(const cv::Mat& left,
                                        const cv::Mat_<std::int16_t>& raw_16ths,
                                        const SearchRange& range, int speckle_size_px,
                                        int speckle_range_px,
                                        const cv::Mat_<std::uint8_t>& confidence = {});

}  // namespace cairn::stereo
