// SPDX-License-Identifier: Apache-2.0
#include "stereo/winner_checks.hpp"

#include <algorithm>
#include <array>
#include <opencv2/imgproc.hpp>

namespace cairn::stereo {
namespace {

/// A surface that turns away lies a fraction of a pixel off for its neighbours.
constexpr int kRightAllowance = 24;

constexpr int kFitSteps = 128;  // of the fit's half pixel

/// The fraction [1/16 px] by the fit's answer [1/256 px]. The fit overstates small fractions: with
/// r its answer, the truth was 0.60 r + 0.66 r^2 on the mean, the same for rendered rooms (with
/// sensor noise) and for a real pair.
constexpr std::array<std::uint8_t, kFitSteps + 1> true_fractions() {
  std::array<std::uint8_t, kFitSteps + 1> fractions{};
  for (int step = 0; step <= kFitSteps; ++step) {
    const double r = step / (2.0 * kFitSteps);
    fractions[static_cast<std::size_t>(step)] =
        static_cast<std::uint8_t>(16 * (0.60 * r + 0.66 * r * r) + 0.5);
  }
  return fractions;
}

constexpr auto kTrueFractions_16ths = true_fractions();

int fraction_16ths(int below, int support, int above) {
  const int fall = support - std::min(below, above);
  if (fall <= 0) return 0;
  const int fit = (above - below) * kFitSteps / fall;
  const int fraction = kTrueFractions_16ths[static_cast<std::size_t>(std::abs(fit))];
  return fit < 0 ? -fraction : fraction;
}

/// Paths agree on whole pixels wherever a surface keeps one disparity along a row, as floors do; so
/// a floor comes out in steps. Each pixel becomes the mean of itself and of those pairs up to
/// kSmoothReach_px to both sides that lie in line with it: a plane of whatever slope stays, its
/// steps go.
constexpr int kSmoothReach_px = 3;
constexpr int kInLine_16ths = 16;
constexpr int kSameSurface_16ths = 48;

std::int16_t in_line_mean(const std::int16_t* at, std::ptrdiff_t stride) {
  const int own = *at;
  int sum = own;
  int count = 1;
  for (int reach = 1; reach <= kSmoothReach_px; ++reach) {
    const int before = at[-reach * stride];
    const int after = at[reach * stride];
    const bool in_line = std::abs(before + after - 2 * own) <= 2 * kInLine_16ths &&
                         std::abs(before - after) <= 2 * kSameSurface_16ths;
    sum += in_line ? before + after : 0;
    count += in_line ? 2 : 0;
  }
  return static_cast<std::int16_t>((sum + count / 2) / count);
}

/// Along columns, then along rows; the borders stay.
cv::Mat_<std::int16_t> without_steps(const cv::Mat_<std::int16_t>& disparity_16ths) {
  cv::Mat_<std::int16_t> down = disparity_16ths.clone();
  for (int row = kSmoothReach_px; row < down.rows - kSmoothReach_px; ++row) {
    for (int col = 0; col < down.cols; ++col) {
      down(row, col) = in_line_mean(&disparity_16ths(row, col),
                                    static_cast<std::ptrdiff_t>(disparity_16ths.step1()));
    }
  }
  cv::Mat_<std::int16_t> both = down.clone();
  for (int row = 0; row < down.rows; ++row) {
    for (int col = kSmoothReach_px; col < down.cols - kSmoothReach_px; ++col) {
      both(row, col) = in_line_mean(&down(row, col), 1);
    }
  }
  return both;
}

/// A mean margin of at least these gives confidence 1, 2, 3. Of the answers of teddy, cones and
/// motorcycle (Middlebury) with confidence 0, 1, 2, 3, off by more than 2 px are 16 to 51, 12 to
/// 26, 5 to 9, and 0.3 to 1.1 %.
constexpr std::array<int, 3> kSureMargins{28, 48, 72};
constexpr int kMarginWindow_px = 5;

}  // namespace

cv::Mat_<std::int16_t> standing_winners(const Winners& winners, const SearchRange& range,
                                        int uniqueness_percent) {
  const int last = range.end_px - range.min_px - 1;
  cv::Mat_<std::int16_t> all_16ths(winners.index.size());
  cv::Mat_<std::uint8_t> stands(winners.index.size());
  for (int row = 0; row < all_16ths.rows; ++row) {
    const std::uint8_t* right_support = winners.right_support[row];
    for (int col = 0; col < all_16ths.cols; ++col) {
      const int index = winners.index(row, col);
      const int support = winners.support(row, col);
      const int fraction =
          index == 0 || index == last
              ? 0
              : fraction_16ths(winners.below(row, col), support, winners.above(row, col));
      all_16ths(row, col) = static_cast<std::int16_t>(16 * (range.min_px + index) + fraction);
      const bool unique = 100 * winners.runner_up(row, col) <= (100 - uniqueness_percent) * support;
      const bool agreed = col < index || right_support[col - index] <= support + kRightAllowance;
      stands(row, col) = unique && agreed ? 1 : 0;
    }
  }
  cv::Mat_<std::int16_t> standing_16ths;
  cv::medianBlur(all_16ths, standing_16ths, 3);
  standing_16ths = without_steps(standing_16ths);
  cv::medianBlur(stands, stands, 3);
  standing_16ths.setTo((range.min_px - 1) * 16, stands == 0);
  return standing_16ths;
}

cv::Mat_<std::uint8_t> winner_confidence(const Winners& winners) {
  cv::Mat margin;
  cv::boxFilter(winners.support - winners.runner_up, margin, CV_8U,
                {kMarginWindow_px, kMarginWindow_px});
  cv::Mat_<std::uint8_t> level_of(1, 256, std::uint8_t{0});
  for (const int sure : kSureMargins) level_of.colRange(sure, 256) += 1;
  cv::Mat confidence;
  cv::LUT(margin, level_of, confidence);
  return confidence;
}

}  // namespace cairn::stereo
