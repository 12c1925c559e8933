// SPDX-License-Identifier: Apache-2.0
#include "odometry/row_matcher.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "odometry/rendered_room.hpp"
#include "stereo/texture.hpp"

namespace cairn::odometry {
namespace {

cv::Mat_<std::uint8_t> draw(cv::Size size, double shift_px, double gain, double offset) {
  cv::Mat_<std::uint8_t> image(size);
  for (int v = 0; v < size.height; ++v) {
    for (int u = 0; u < size.width; ++u) {
      double sum = 0;
      for (const double dv : {-0.25, 0.25}) {
        for (const double du : {-0.25, 0.25}) {
          sum += testing::surface_grey(u + du + shift_px, v + dv, 4, 17) / 4;
        }
      }
      image(v, u) = cv::saturate_cast<std::uint8_t>(gain * sum + offset);
    }
  }
  return image;
}

TEST(RowMatcher, FindsTheShiftToAFewHundredthsOfAPixel) {
  const cv::Size size{400, 120};
  const cv::Mat left = draw(size, 0, 1, 0);
  for (const double shift_px : {10.0, 10.2, 10.5, 37.8, 61.35}) {
    // The other camera is brighter and flatter.
    const cv::Mat right = draw(size, shift_px, 0.7, 40);
    const RowMatcher matcher(left, right);
    double sum = 0;
    double squares = 0;
    int found = 0;
    int tried = 0;
    for (int v = 15; v < 105; v += 12) {
      for (int u = 90; u < 380; u += 12) {
        ++tried;
        const auto match = matcher.match_both_ways(u + 0.3, v + 0.6, 0, 80);
        if (!match) continue;
        ++found;
        const double error = match->disparity_px - shift_px;
        sum += error;
        squares += error * error;
        EXPECT_LT(std::abs(error), 0.3);
      }
    }
    SCOPED_TRACE(shift_px);
    EXPECT_GT(found, 0.8 * tried);
    EXPECT_LT(std::abs(sum / found), 0.02);
    EXPECT_LT(std::sqrt(squares / found), 0.03);
  }
}

TEST(RowMatcher, RefusesPlainRepeatingAndMissingWindows) {
  const cv::Mat plain(100, 200, CV_8UC1, cv::Scalar(90));
  EXPECT_FALSE(RowMatcher(plain, plain).match(100, 50, 0, 64));

  cv::Mat_<std::uint8_t> stripes(100, 200);
  for (int v = 0; v < 100; ++v) {
    for (int u = 0; u < 200; ++u) {
      stripes(v, u) = static_cast<std::uint8_t>(std::lround(128 + 90 * std::sin(u * 0.7)));
    }
  }
  EXPECT_FALSE(RowMatcher(stripes, stripes).match(120, 50, 0, 64));
  EXPECT_TRUE(RowMatcher(stripes, stripes).match(120, 50, -2, 2)) << "alone in a narrow range";

  const cv::Mat left = draw({200, 100}, 0, 1, 0);
  const cv::Mat right = draw({200, 100}, 20, 1, 0);
  const RowMatcher matcher(left, right);
  EXPECT_TRUE(matcher.match(100, 50, 0, 64));
  EXPECT_FALSE(matcher.match(100, 50, 30, 64)) << "the true disparity is not searched";
  for (const auto& [u, v] : {std::pair{2.0, 50.0},
                             {198.0, 50.0},
                             {100.0, 1.0},
                             {100.0, 99.0},
                             {-5.0, -5.0},
                             {1e6, 50.0},
                             {15.0, 50.0}}) {
    EXPECT_FALSE(matcher.match(u, v, 0, 64)) << u << " " << v;
  }
  EXPECT_FALSE(matcher.match(100, 50, 64, 0)) << "an empty range";
}

}  // namespace
}  // namespace cairn::odometry
