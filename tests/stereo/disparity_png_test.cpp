// SPDX-License-Identifier: Apache-2.0
#include "stereo/disparity_png.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <random>
#include <string>

#include "core/atomic_file.hpp"

namespace cairn::stereo {
namespace {

class DisparityPng : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
    folder_ = std::filesystem::temp_directory_path() /
              ("cairn_" + std::to_string(::getpid()) + "_" + info->name());
    std::filesystem::create_directories(folder_);
    camera_.width_px = 12;
    camera_.height_px = 8;
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  DisparityImage some_disparities() const {
    DisparityImage image;
    image.step_px = 2;
    image.camera = camera_;
    image.disparity_16ths = cv::Mat_<std::uint16_t>::zeros(4, 6);
    image.code = cv::Mat_<std::uint8_t>::zeros(4, 6);
    image.disparity_16ths(1, 2) = 1;
    image.disparity_16ths(3, 5) = 4095;
    image.disparity_16ths(0, 0) = 777;
    return image;
  }

  std::filesystem::path folder_;
  RectifiedCamera camera_;
};

TEST_F(DisparityPng, ComesBackAsItWas) {
  const auto path = folder_ / "d.png";
  const auto image = some_disparities();
  ASSERT_TRUE(write_disparity_png(path, image));
  const auto back = read_disparity_png(path, camera_, 2);
  ASSERT_TRUE(back) << back.error().message;
  EXPECT_EQ(cv::countNonZero(back->disparity_16ths != image.disparity_16ths), 0);
  EXPECT_EQ(back->code(1, 2), 3);
  EXPECT_EQ(back->code(1, 3), static_cast<int>(Reason::kNoData));
}

TEST_F(DisparityPng, HoldsDisparityTimes256) {
  const auto path = folder_ / "d.png";
  ASSERT_TRUE(write_disparity_png(path, some_disparities()));
  const cv::Mat png = cv::imread(path.string(), cv::IMREAD_UNCHANGED);
  ASSERT_EQ(png.type(), CV_16UC1);
  EXPECT_EQ(png.at<std::uint16_t>(0, 0), 777 * 16);
  EXPECT_EQ(png.at<std::uint16_t>(2, 2), 0);
}

TEST_F(DisparityPng, KeepsASmallAnswerAnAnswer) {
  const auto path = folder_ / "d.png";
  const cv::Mat_<std::uint16_t> png = (cv::Mat_<std::uint16_t>(1, 2) << 3, 0);
  cv::imwrite(path.string(), png);
  camera_.width_px = 2;
  camera_.height_px = 1;
  const auto image = read_disparity_png(path, camera_, 1);
  ASSERT_TRUE(image);
  EXPECT_EQ(image->disparity_16ths(0, 0), 1);
  EXPECT_EQ(image->disparity_16ths(0, 1), 0);
}

TEST_F(DisparityPng, RefusesWhatDoesNotFitTheFormat) {
  auto image = some_disparities();
  image.disparity_16ths(0, 0) = 4096;
  const auto written = write_disparity_png(folder_ / "d.png", image);
  ASSERT_FALSE(written);
  EXPECT_NE(written.error().message.find("d.png"), std::string::npos);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "d.png"));
  EXPECT_FALSE(write_disparity_png(folder_ / "d.png", DisparityImage{}));
}

TEST_F(DisparityPng, RefusesOtherFilesAndSizes) {
  const auto path = folder_ / "d.png";
  EXPECT_FALSE(read_disparity_png(path, camera_, 2));
  cv::imwrite(path.string(), cv::Mat::zeros(4, 6, CV_8UC1));
  EXPECT_FALSE(read_disparity_png(path, camera_, 2));
  cv::imwrite(path.string(), cv::Mat::zeros(4, 7, CV_16UC1));
  EXPECT_FALSE(read_disparity_png(path, camera_, 2));
  EXPECT_FALSE(read_disparity_png(path, camera_, 0));
}

TEST_F(DisparityPng, SurvivesDamage) {
  const auto path = folder_ / "d.png";
  ASSERT_TRUE(write_disparity_png(path, some_disparities()));
  const auto whole = read_file(path);
  ASSERT_TRUE(whole);
  constexpr unsigned kSeed = 20240611;
  SCOPED_TRACE("seed " + std::to_string(kSeed));
  std::mt19937 random(kSeed);
  ::testing::internal::CaptureStderr();  // libpng prints each complaint
  for (int i = 0; i < 2000; ++i) {
    auto bytes = *whole;
    const unsigned changes = 1 + random() % 4;
    for (unsigned k = 0; k < changes; ++k) {
      bytes[random() % bytes.size()] = static_cast<std::uint8_t>(random());
    }
    if (random() % 3 == 0) bytes.resize(random() % bytes.size());
    std::ofstream(path, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()),
               static_cast<std::streamsize>(bytes.size()));
    const auto image = read_disparity_png(path, camera_, 2);
    if (image) {
      EXPECT_EQ(image->disparity_16ths.size(), cv::Size(6, 4));
    }
  }
  ::testing::internal::GetCapturedStderr();
}

}  // namespace
}  // namespace cairn::stereo
