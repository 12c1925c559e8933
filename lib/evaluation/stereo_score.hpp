// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <opencv2/core.hpp>
#include <optional>

#include "core/result.hpp"

namespace cairn::evaluation {

/// Reads a 16-bit grey PNG as disparity in pixels: value / 256, 0 = unknown. Images over 2^26
/// pixels are refused.
[[nodiscard]] Result<cv::Mat_<float>> read_disparity_png(const std::filesystem::path& file);

/// Reads a PNG in grey values: pixels of 250 and more are to be evaluated (255 in the result),
/// others not (0).
[[nodiscard]] Result<cv::Mat_<std::uint8_t>> read_mask_png(const std::filesystem::path& file);

/// One matcher's answer to one pair, and what is known of the truth. All images are of one size.
struct StereoCase {
  cv::Mat_<float> answer_px;    ///< disparity; no answer where not above 0
  cv::Mat_<float> truth_px;     ///< disparity; unknown where not above 0
  cv::Mat_<std::uint8_t> mask;  ///< 255 = evaluate; empty: everywhere
  cv::Mat_<float> confidence;   ///< higher is surer; needed for bad2_at_density alone; may be empty
};

/// Shares are fractions of 1. The errors of a case without an answered pixel are not known.
struct StereoScore {
  std::size_t truth_pixels = 0;     ///< with truth, in the mask
  std::size_t answered_pixels = 0;  ///< of these
  double density = 0;               ///< answered / truth
  double bad2_invalid = 0;          ///< (off by more than 2 px, or not answered) / truth
  std::optional<double> bad1;       ///< off by more than 1 px / answered
  std::optional<double> bad2;       ///< off by more than 2 px / answered
  std::optional<double> d1;  ///< off by more than 3 px and 5 % of the truth / answered (KITTI 2015)
  std::optional<double> epe_px;  ///< mean error of the answered
  std::optional<double> rms_px;
  std::optional<double> median_px;
  std::optional<double> p95_px;
  /// bad2 of the surest pixels, as many as make `at_density` of the truth (all where there are not
  /// as many). Of pixels equally sure, of which only some fit, each counts in part: the mean over
  /// all choices.
  std::optional<double> bad2_at_density;
};

/// Refuses images of different sizes, a case without truth, and at_density without a confidence.
[[nodiscard]] Result<StereoScore> score_stereo(const StereoCase& images,
                                               std::optional<double> at_density = std::nullopt);

}  // namespace cairn::evaluation
