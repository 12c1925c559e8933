// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>

#include "stereo/path_aggregation.hpp"
#include "stereo/pixel_grading.hpp"

namespace cairn::stereo {

/// The winners' disparities [1/16 px], the median over 3x3 of all of them; range.min_px * 16 - 16
/// where the winner does not stand. It stands if no left pixel supports its right pixel better by
/// more than a small allowance, and if the runner-up's support is at least `uniqueness_percent`
/// below its own. A line through the supports of the winner and of the lesser of its neighbours,
/// met by one of the opposite slope through the other neighbour's, gives the fraction (the
/// equiangular fit of Shimizu and Okutomi 2001), corrected by a measured curve; the first and the
/// last disparity searched have none. After the median, the mean of what lies in line within 3 px
/// along the column, then along the row.
[[nodiscard]] cv::Mat_<std::int16_t> standing_winners(const Winners& winners,
                                                      const SearchRange& range,
                                                      int uniqueness_percent);

/// Confidence 0 to 3: how far the winner's support lies above the runner-up's, on the mean over
/// 5x5.
[[nodiscard]] cv::Mat_<std::uint8_t> winner_confidence(const Winners& winners);

}  // namespace cairn::stereo
