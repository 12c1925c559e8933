// SPDX-License-Identifier: Apache-2.0
#include "stereo/pixel_grading.hpp"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "stereo/disparity_image.hpp"
#include "stereo/speckles.hpp"

namespace cairn::stereo {
namespace {

constexpr int kTextureWindow_px = 9;
constexpr int kSobelGain = 8;  // of the 3x3 kernel, per grey level and px
constexpr float kLowTexture_per_px = 1.0F;
constexpr std::array<int, 3> kReaches_px{2, 4, 8};  // for confidence 1, 2, 3
constexpr int kAgreement_16ths = 8;
constexpr int kClaimMargin_16ths = 16;
constexpr int kUnclaimed = -1;

enum class Fate : std::uint8_t { kAnswer, kOutside, kOutOfRange, kRefused };

cv::Mat_<float> horizontal_texture(const cv::Mat& image) {
  cv::Mat gradient;
  cv::Sobel(image, gradient, CV_16S, 1, 0, 3);
  cv::Mat texture;
  cv::boxFilter(cv::abs(gradient), texture, CV_32F, {kTextureWindow_px, kTextureWindow_px});
  return cv::Mat(texture / kSobelGain);
}

/// True if the answers `reach_px` away on either side, in all four directions, are there and lie on
/// a straight line with the pixel's own, within kAgreement_16ths at its middle (twice that in their
/// sum).
bool lies_on_a_surface(const cv::Mat_<std::int16_t>& disparity, int row, int col, int reach_px,
                       int first_16ths) {
  if (row < reach_px || col < reach_px || row + reach_px >= disparity.rows ||
      col + reach_px >= disparity.cols) {
    return false;
  }
  constexpr std::array<std::array<int, 2>, 4> kDirections{{{0, 1}, {1, 0}, {1, 1}, {1, -1}}};
  for (const auto& [down, right] : kDirections) {
    const int before = disparity(row - down * reach_px, col - right * reach_px);
    const int after = disparity(row + down * reach_px, col + right * reach_px);
    if (before < first_16ths || after < first_16ths) return false;
    if (std::abs(before + after - 2 * disparity(row, col)) > 2 * kAgreement_16ths) return false;
  }
  return true;
}

int surface_level(const cv::Mat_<std::int16_t>& disparity, int row, int col, int first_16ths) {
  int level = 0;
  for (const int reach_px : kReaches_px) {
    if (!lies_on_a_surface(disparity, row, col, reach_px, first_16ths)) break;
    ++level;
  }
  return level;
}

int right_column(int col, int disparity_16ths) { return col - (disparity_16ths + 8) / 16; }

/// Per row: what has to be known besides the pixel itself.
class RowGrader {
 public:
  RowGrader(const SearchRange& range, int cols)
      : range_{range}, claimed_(static_cast<std::size_t>(cols)), background_(claimed_.size()) {}

  void load(const std::int16_t* disparity, int cols) {
    std::fill(claimed_.begin(), claimed_.end(), kUnclaimed);
    for (int col = 0; col < cols; ++col) {
      if (disparity[col] < range_.min_px * 16) continue;
      int& claim = claimed_[index(right_column(col, disparity[col]))];
      claim = std::max<int>(claim, disparity[col]);
    }
    find_background(disparity, cols);
  }

  [[nodiscard]] bool claim_is_its_own(int col, int disparity_16ths) const {
    const int claim = claimed_[index(right_column(col, disparity_16ths))];
    return claim - disparity_16ths <= kClaimMargin_16ths;
  }

  /// True if what lies behind the pixel's neighbours would be seen beyond the right image's edge,
  /// or at a pixel of it that something nearer has taken.
  [[nodiscard]] bool is_hidden(int col) const {
    const int behind = background_[index(col)];
    if (behind == kUnclaimed) return false;
    const int there = right_column(col, behind);
    return there < 0 || claimed_[index(there)] > behind + kClaimMargin_16ths;
  }

 private:
  static std::size_t index(int col) { return static_cast<std::size_t>(col); }

  /// The lesser of the nearest answers to the left and to the right.
  void find_background(const std::int16_t* disparity, int cols) {
    int last = kUnclaimed;
    for (int col = 0; col < cols; ++col) {
      if (disparity[col] >= range_.min_px * 16) last = disparity[col];
      background_[index(col)] = last;
    }
    last = kUnclaimed;
    for (int col = cols - 1; col >= 0; --col) {
      if (disparity[col] >= range_.min_px * 16) last = disparity[col];
      int& behind = background_[index(col)];
      if (behind == kUnclaimed || (last != kUnclaimed && last < behind)) behind = last;
    }
  }

  SearchRange range_;
  std::vector<int> claimed_;
  std::vector<int> background_;
};

}  // namespace

GradedPixels grade_pixels(const cv::Mat& left, const cv::Mat_<std::int16_t>& raw_16ths,
                          const SearchRange& range, int speckle_size_px, int speckle_range_px,
                          const cv::Mat_<std::uint8_t>& confidence) {
  const int first_16ths = range.min_px * 16;
  const int last_16ths = (range.end_px - 1) * 16;
  const auto no_answer = static_cast<std::int16_t>(first_16ths - 16);

  cv::Mat_<std::int16_t> disparity = raw_16ths.clone();
  cv::Mat_<std::uint8_t> fate(disparity.size());
  for (int row = 0; row < disparity.rows; ++row) {
    for (int col = 0; col < disparity.cols; ++col) {
      std::int16_t& d = disparity(row, col);
      Fate is = Fate::kAnswer;
      if (col < range.min_px) {
        is = Fate::kOutside;
      } else if (d < first_16ths) {
        is = Fate::kRefused;
      } else if (right_column(col, d) < 0) {
        is = Fate::kOutside;
      } else if (d == first_16ths || d >= last_16ths) {
        is = Fate::kOutOfRange;
      }
      if (is != Fate::kAnswer) d = no_answer;
      fate(row, col) = static_cast<std::uint8_t>(is);
    }
  }
  if (speckle_size_px > 0) {
    remove_speckles(disparity, no_answer, speckle_size_px, 16 * speckle_range_px);
  }

  GradedPixels graded{cv::Mat_<std::uint16_t>(disparity.size(), std::uint16_t{0}),
                      cv::Mat_<std::uint8_t>(disparity.size())};
  const cv::Mat_<float> texture = horizontal_texture(left);
  RowGrader grader(range, disparity.cols);
  for (int row = 0; row < disparity.rows; ++row) {
    grader.load(disparity[row], disparity.cols);
    for (int col = 0; col < disparity.cols; ++col) {
      const int d = disparity(row, col);
      const auto is = static_cast<Fate>(fate(row, col));
      std::uint8_t& code = graded.code(row, col);
      if (d >= first_16ths) {
        graded.disparity_16ths(row, col) = static_cast<std::uint16_t>(d);
        if (!confidence.empty()) {
          code = confidence(row, col);
          continue;
        }
        const int cap = texture(row, col) < kLowTexture_per_px ? 1 : 3;
        const int level =
            grader.claim_is_its_own(col, d) ? surface_level(disparity, row, col, first_16ths) : 0;
        code = static_cast<std::uint8_t>(std::min(level, cap));
        continue;
      }
      Reason reason = Reason::kAmbiguous;
      if (is == Fate::kOutside || is == Fate::kAnswer) {
        reason = Reason::kNoData;
      } else if (is == Fate::kOutOfRange) {
        reason = Reason::kOutOfRange;
      } else if (texture(row, col) < kLowTexture_per_px) {
        reason = Reason::kLowTexture;
      } else if (grader.is_hidden(col)) {
        reason = Reason::kNoData;
      }
      code = static_cast<std::uint8_t>(reason);
    }
  }
  return graded;
}

}  // namespace cairn::stereo
