// SPDX-License-Identifier: Apache-2.0
#include "stereo/speckles.hpp"

#include <gtest/gtest.h>

#include <opencv2/calib3d.hpp>
#include <random>

namespace cairn::stereo {
namespace {

constexpr std::int16_t kNoAnswer = -16;

TEST(Speckles, AreThoseOfOpenCv) {
  std::mt19937 random(1);
  for (int i = 0; i < 200; ++i) {
    cv::Mat_<std::int16_t> ours(1 + static_cast<int>(random() % 60),
                                1 + static_cast<int>(random() % 60));
    const int levels = 2 + static_cast<int>(random() % 8);
    const int spacing = 10 + static_cast<int>(random() % 30);
    for (auto& d : ours) {
      const int level = static_cast<int>(random()) % levels;
      d = random() % 3 == 0 ? kNoAnswer : static_cast<std::int16_t>(std::abs(level) * spacing);
    }
    cv::Mat_<std::int16_t> truth = ours.clone();
    const int size_px = static_cast<int>(random() % 30);
    remove_speckles(ours, kNoAnswer, size_px, 32);
    cv::filterSpeckles(truth, kNoAnswer, size_px, 32);
    ASSERT_EQ(cv::countNonZero(ours != truth), 0) << ours.size() << " size " << size_px;
  }
}

TEST(Speckles, AnIslandThatTurnsBackOnItselfIsOne) {
  // A horseshoe: its arms meet only in the last row.
  cv::Mat_<std::int16_t> image(5, 5, kNoAnswer);
  image.col(0) = 80;
  image.col(4) = 80;
  image.row(4) = 80;
  const cv::Mat_<std::int16_t> before = image.clone();
  remove_speckles(image, kNoAnswer, 12, 16);
  EXPECT_EQ(cv::countNonZero(image != before), 0);
  remove_speckles(image, kNoAnswer, 13, 16);
  EXPECT_EQ(cv::countNonZero(image != kNoAnswer), 0);
}

}  // namespace
}  // namespace cairn::stereo
