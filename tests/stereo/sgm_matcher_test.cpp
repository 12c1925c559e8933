// SPDX-License-Identifier: Apache-2.0
#include "stereo/sgm_matcher.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>

#include "texture.hpp"

namespace cairn::stereo {
namespace {

struct Pair {
  cv::Mat_<std::uint8_t> left;
  cv::Mat_<std::uint8_t> right;
};

MatcherConfig sgm(int min_px, int max_px) {
  MatcherConfig config;
  config.method = "sgm";
  config.min_disparity_px = min_px;
  config.max_disparity_px = max_px;
  config.downscale = 1;
  config.output_step_px = 1;
  return config;
}

DisparityImage match(const MatcherConfig& config, const Pair& pair) {
  RectifiedCamera camera;
  camera.f_px = 554;
  camera.baseline_m = 0.254;
  camera.width_px = pair.left.cols;
  camera.height_px = pair.left.rows;
  auto image = make_matcher(config).value()->match(pair.left, pair.right, camera, 42);
  EXPECT_TRUE(image) << (image ? "" : image.error().message);
  return std::move(*image);
}

bool has_reason(const DisparityImage& image, int row, int col, Reason reason) {
  return !image.valid(row, col) && image.code(row, col) == static_cast<int>(reason);
}

/// A wall whose right view lies `disparity_px` further left, seen by cameras with some noise: the
/// bias of a fit depends on it.
Pair wall(cv::Size size, double disparity_px) {
  Pair pair{cv::Mat_<std::uint8_t>(size), cv::Mat_<std::uint8_t>(size)};
  std::mt19937 random(9);
  std::normal_distribution<double> noise_grey(0, 3);
  const auto grey = [&](double x, double y) {
    return cv::saturate_cast<std::uint8_t>(testing::surface_grey(x, y, 3, 7) + noise_grey(random));
  };
  for (int row = 0; row < size.height; ++row) {
    for (int col = 0; col < size.width; ++col) {
      pair.left(row, col) = grey(col, row);
      pair.right(row, col) = grey(col + disparity_px, row);
    }
  }
  return pair;
}

TEST(SgmMatcher, FindsFractionsOfAPixel) {
  for (int sixteenth = 0; sixteenth < 16; ++sixteenth) {
    const double truth_px = 20 + sixteenth / 16.0;
    const auto image = match(sgm(4, 60), wall({240, 120}, truth_px));
    double sum = 0;
    double squares = 0;
    int count = 0;
    for (int row = 10; row < 110; ++row) {
      for (int col = 40; col < 230; ++col) {
        if (!image.valid(row, col)) continue;
        const double error = image.disparity_px(row, col) - truth_px;
        sum += error;
        squares += error * error;
        ++count;
      }
    }
    std::printf("%6.4f px: mean error %+.3f px, rms %.3f px, %d answers\n", truth_px, sum / count,
                std::sqrt(squares / count), count);
    EXPECT_GT(count, 0.95 * 100 * 190);
    // On a wall that faces the cameras every path says the same whole number, so the fit is at its
    // worst: a slope is an order better (Matcher.EveryVariantFindsThePlane).
    EXPECT_LT(std::abs(sum / count), 0.25) << truth_px;
    EXPECT_LT(std::sqrt(squares / count), 0.3) << truth_px;
  }
}

/// Random dots: a background at 8 px, a square in front of it at 20 px.
struct RandomDots {
  static constexpr int kBack_px = 8;
  static constexpr int kFront_px = 20;
  cv::Rect square{100, 40, 80, 80};
  Pair pair{cv::Mat_<std::uint8_t>(160, 260), cv::Mat_<std::uint8_t>(160, 260)};

  RandomDots() {
    std::mt19937 random(5);
    for (auto* image : {&pair.left, &pair.right}) {
      for (auto& dot : *image) dot = static_cast<std::uint8_t>(random());
    }
    for (int row = 0; row < 160; ++row) {
      for (const bool front : {false, true}) {
        for (int col = kFront_px; col < 260; ++col) {
          if (square.contains({col, row}) != front) continue;
          pair.right(row, col - (front ? kFront_px : kBack_px)) = pair.left(row, col);
        }
      }
    }
  }
};

TEST(SgmMatcher, SeesASquareInFrontAndDoesNotInventWhatItHides) {
  const RandomDots dots;
  const auto image = match(sgm(0, 64), dots.pair);
  int right = 0;
  int wrong = 0;
  int hidden_answered = 0;
  int hidden = 0;
  for (int row = 50; row < 110; ++row) {
    for (int col = 30; col < 250; ++col) {
      const bool front = dots.square.contains({col, row});
      const int shift_px = RandomDots::kFront_px - RandomDots::kBack_px;
      if (!front && dots.square.contains({col + shift_px, row})) {
        ++hidden;
        hidden_answered += image.valid(row, col) ? 1 : 0;
      } else if (image.valid(row, col)) {
        const int truth_px = front ? RandomDots::kFront_px : RandomDots::kBack_px;
        (std::abs(image.disparity_px(row, col) - truth_px) <= 1 ? right : wrong) += 1;
      }
    }
  }
  EXPECT_EQ(hidden, 60 * 12);
  EXPECT_LT(hidden_answered, 0.25 * hidden);
  EXPECT_GT(right, 0.97 * (60 * 220 - hidden));
  EXPECT_LT(wrong, 0.01 * right);
}

TEST(SgmMatcher, WhatPointsBeyondTheRightImageIsNoData) {
  const auto image = match(sgm(0, 64), wall({240, 120}, 40));
  int no_data = 0;
  for (int row = 10; row < 110; ++row) {
    for (int col = 0; col < 38; ++col) {
      no_data += has_reason(image, row, col, Reason::kNoData) ? 1 : 0;
      EXPECT_FALSE(image.valid(row, col) && image.disparity_px(row, col) > col + 1);
    }
  }
  EXPECT_GT(no_data, 0.8 * 100 * 38);
}

TEST(SgmMatcher, WhatIsNearerThanTheRangeIsSaidToBe) {
  const auto image = match(sgm(0, 32), wall({240, 120}, 31));
  int out_of_range = 0;
  for (int row = 10; row < 110; ++row) {
    for (int col = 50; col < 230; ++col) {
      out_of_range += has_reason(image, row, col, Reason::kOutOfRange) ? 1 : 0;
    }
  }
  EXPECT_GT(out_of_range, 0.9 * 100 * 180);
}

TEST(SgmMatcher, DoesNotMindAnotherExposure) {
  const Pair plain = wall({240, 120}, 20.3);
  Pair darker = plain;
  plain.right.convertTo(darker.right, CV_8U, 0.7, 12);
  const auto image = match(sgm(0, 64), darker);
  int good = 0;
  for (int row = 10; row < 110; ++row) {
    for (int col = 40; col < 230; ++col) {
      good += image.valid(row, col) && std::abs(image.disparity_px(row, col) - 20.3) < 0.5 ? 1 : 0;
    }
  }
  EXPECT_GT(good, 0.95 * 100 * 190);
}

TEST(SgmMatcher, RefusesMoreDisparitiesThanAByteHolds) {
  EXPECT_TRUE(make_matcher(sgm(0, 256)));
  EXPECT_TRUE(make_matcher(sgm(100, 356)));
  EXPECT_FALSE(make_matcher(sgm(0, 257)));
  EXPECT_FALSE(make_matcher(sgm(15, 16)));
}

TEST(SgmMatcher, TakesImagesNarrowerThanTheRange) {
  const auto image = match(sgm(20, 276), wall({33, 20}, 3));
  EXPECT_EQ(image.disparity_16ths.size(), cv::Size(33, 20));
  for (int row = 0; row < 20; ++row) {
    for (int col = 0; col < 33; ++col) {
      if (!image.valid(row, col)) continue;
      EXPECT_LE(image.disparity_px(row, col), col + 0.5);
    }
  }
}

}  // namespace
}  // namespace cairn::stereo
