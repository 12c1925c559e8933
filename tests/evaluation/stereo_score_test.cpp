// SPDX-License-Identifier: Apache-2.0
#include "evaluation/stereo_score.hpp"

#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <random>

#include "data_folder.hpp"
#include "evaluation/corruption.hpp"
#include "evaluation/temporary_files.hpp"

namespace cairn::evaluation {
namespace {

using Image = cv::Mat_<float>;

class DisparityFile : public TemporaryFiles {};

/// Ten pixels in a row: eight with truth, six of them answered, with errors 0.5, 1, 1.5, 2.5, 4 and
/// 8 px.
StereoCase ten_pixels() {
  StereoCase images;
  images.truth_px = (Image(1, 10) << 10, 10, 10, 10, 100, 40, 20, 20, 0, 0);
  images.answer_px = (Image(1, 10) << 10.5, 9, 11.5, 12.5, 104, 48, 0, -1, 5, 0);
  return images;
}

TEST(ScoreStereo, ByHand) {
  const auto score = score_stereo(ten_pixels());
  ASSERT_TRUE(score);
  EXPECT_EQ(score->truth_pixels, 8U);
  EXPECT_EQ(score->answered_pixels, 6U);
  EXPECT_DOUBLE_EQ(score->density, 6.0 / 8);
  EXPECT_DOUBLE_EQ(*score->bad1, 4.0 / 6);         // 1.5, 2.5, 4, 8; exactly 1 is not over 1
  EXPECT_DOUBLE_EQ(*score->bad2, 3.0 / 6);         // 2.5, 4, 8
  EXPECT_DOUBLE_EQ(score->bad2_invalid, 5.0 / 8);  // and two without an answer
  EXPECT_DOUBLE_EQ(*score->d1, 1.0 / 6);           // 8 of 40; 4 px are under 5 % of 100
  EXPECT_DOUBLE_EQ(*score->epe_px, 17.5 / 6);
  // 0.25 + 1 + 2.25 + 6.25 + 16 + 64 = 89.75
  EXPECT_DOUBLE_EQ(*score->rms_px, std::sqrt(89.75 / 6));
  EXPECT_DOUBLE_EQ(*score->median_px, 1.5);  // third of six
  EXPECT_DOUBLE_EQ(*score->p95_px, 8);       // ceil(5.7) = sixth
  EXPECT_FALSE(score->bad2_at_density);
}

TEST(ScoreStereo, TheMaskLeavesPixelsOut) {
  StereoCase images = ten_pixels();
  images.mask = cv::Mat_<std::uint8_t>(1, 10, static_cast<std::uint8_t>(255));
  images.mask(0, 5) = 0;
  images.mask(0, 6) = 128;
  const auto score = score_stereo(images);
  ASSERT_TRUE(score);
  EXPECT_EQ(score->truth_pixels, 6U);
  EXPECT_DOUBLE_EQ(*score->bad2, 2.0 / 5);
  EXPECT_DOUBLE_EQ(score->bad2_invalid, 3.0 / 6);
}

TEST(ScoreStereo, KeepsTheSurestDownToADensity) {
  StereoCase images = ten_pixels();
  // Errors by confidence: 3: 0.5, 4 | 2: 1, 1.5 | 1: 2.5 | 0: 8.
  images.confidence = (Image(1, 10) << 3, 2, 2, 1, 3, 0, 0, 0, 3, 3);
  const auto bad2_at = [&](double density) {
    const auto score = score_stereo(images, density);
    return score ? *score->bad2_at_density : -1;
  };
  EXPECT_DOUBLE_EQ(bad2_at(4.0 / 8), 1.0 / 4);  // 0.5, 4, 1, 1.5
  EXPECT_DOUBLE_EQ(bad2_at(3.0 / 8), 1.0 / 3);  // 0.5, 4 and one of two good ones
  EXPECT_DOUBLE_EQ(bad2_at(1.0 / 8), 1.0 / 2);  // one of 0.5 and 4: either
  EXPECT_DOUBLE_EQ(bad2_at(5.0 / 8), 2.0 / 5);
  EXPECT_DOUBLE_EQ(bad2_at(1.0), 3.0 / 6);  // there are only six
}

TEST(ScoreStereo, WithoutAnAnswerTheErrorsAreNotKnown) {
  StereoCase images = ten_pixels();
  images.answer_px = Image(1, 10, std::nanf(""));
  const auto score = score_stereo(images);
  ASSERT_TRUE(score);
  EXPECT_EQ(score->density, 0);
  EXPECT_EQ(score->bad2_invalid, 1);
  EXPECT_FALSE(score->bad2);
  EXPECT_FALSE(score->epe_px);
}

TEST(ScoreStereo, RefusesWhatDoesNotFit) {
  StereoCase images = ten_pixels();
  images.answer_px = Image(1, 9, 1.0F);
  EXPECT_FALSE(score_stereo(images));
  images = ten_pixels();
  EXPECT_FALSE(score_stereo(images, 0.5));
  images.truth_px = Image(1, 10, 0.0F);
  EXPECT_FALSE(score_stereo(images));
  EXPECT_FALSE(score_stereo({}));
}

TEST_F(DisparityFile, ValueIs256thsOfAPixel) {
  const cv::Mat_<std::uint16_t> raw = (cv::Mat_<std::uint16_t>(1, 3) << 0, 256, 3264);
  const std::string file = (folder_ / "d.png").string();
  ASSERT_TRUE(cv::imwrite(file, raw));
  const auto read = read_disparity_png(file);
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ((*read)(0, 0), 0);
  EXPECT_EQ((*read)(0, 1), 1);
  EXPECT_EQ((*read)(0, 2), 12.75F);
}

TEST_F(DisparityFile, WhatIsNoDisparityImageIsRefusedByName) {
  const std::string grey = (folder_ / "g.png").string();
  ASSERT_TRUE(cv::imwrite(grey, cv::Mat_<std::uint8_t>(2, 2, static_cast<std::uint8_t>(9))));
  EXPECT_EQ(read_disparity_png(grey).error().message, grey + ": is not a 16-bit grey image");
  const std::string text = write("t.png", "no image at all, only some words").string();
  EXPECT_EQ(read_disparity_png(text).error().message, text + ": is not a PNG");
  // A header that claims 2^31 x 2^31 pixels.
  std::string forged("\x89PNG\r\n\x1a\n\0\0\0\rIHDR\x7f\xff\xff\xff\x7f\xff\xff\xff\x10\0\0\0\0",
                     29);
  EXPECT_NE(read_disparity_png(write("f.png", forged)).error().message.find("pixels"),
            std::string::npos);
}

TEST_F(DisparityFile, ReaderSurvivesCorruption) {
  cv::Mat_<std::uint16_t> raw(12, 16);
  for (int i = 0; i < 12 * 16; ++i) raw(i / 16, i % 16) = static_cast<std::uint16_t>(i * 331);
  std::vector<std::uint8_t> png;
  ASSERT_TRUE(cv::imencode(".png", raw, png));
  const std::string bytes(png.begin(), png.end());
  constexpr unsigned kSeed = 77;
  std::mt19937 random(kSeed);
  for (int trial = 0; trial < 2000; ++trial) {
    const auto read = read_disparity_png(write("c.png", corrupted(bytes, random)));
    ASSERT_TRUE(read || !read.error().message.empty()) << "seed " << kSeed << " trial " << trial;
  }
}

TEST_F(DisparityFile, RealTruthScoresItselfPerfectly) {
  const auto data = testing::data_folder();
  if (!data) GTEST_SKIP() << "no data folder: set CAIRN_DATA";
  const auto truth = read_disparity_png(*data / "stereo/gt/teddy/gt16.png");
  ASSERT_TRUE(truth) << truth.error().message;
  const auto mask = read_mask_png(*data / "stereo/gt/teddy/mask_nonocc.png");
  ASSERT_TRUE(mask) << mask.error().message;
  const auto score = score_stereo({*truth, *truth, *mask, {}});
  ASSERT_TRUE(score);
  EXPECT_EQ(score->density, 1);
  EXPECT_EQ(*score->bad1, 0);
  EXPECT_GT(score->truth_pixels, 100'000U);
}

}  // namespace
}  // namespace cairn::evaluation
