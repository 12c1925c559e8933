// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "data_folder.hpp"
#include "messages/image_messages.hpp"

namespace cairn::messages {
namespace {

constexpr int kSeed = 11;

/// Smooth shapes under noise: what JPEG makes of it depends on how much noise there is.
camera::Frame noisy_frame(int index, double noise, cv::Size size = {640, 480}) {
  cv::RNG rng(static_cast<std::uint64_t>(kSeed + index));
  camera::Frame frame;
  frame.index = index;
  frame.utime = 1000 + index;
  frame.exposure_us = 5;
  for (cv::Mat* image : {&frame.left, &frame.right}) {
    cv::Mat grain(size, CV_8UC1);
    rng.fill(grain, cv::RNG::NORMAL, 0, noise);
    image->create(size, CV_8UC1);
    image->setTo(90);
    cv::circle(*image, {size.width / 2, size.height / 2}, size.height / 3, 160, cv::FILLED);
    *image += grain;
  }
  return frame;
}

bool equal(const cv::Mat& a, const cv::Mat& b) { return cv::norm(a, b, cv::NORM_INF) == 0; }

std::string error_of(const stereo_frame_t& message) {
  const auto images = to_images(message);
  return images ? "none" : images.error().message;
}

TEST(ImageMessages, RawImagesComeBackExactlyAlsoFromAPartOfALargerOne) {
  const camera::Frame whole = noisy_frame(0, 30);
  camera::Frame frame = whole;
  const cv::Rect part(10, 20, 200, 150);
  frame.left = whole.left(part);
  frame.right = whole.right(part);
  const auto message = FrameEncoder(ImageEncoding::kRaw).encode(frame, 0xfeedfacecafebeefULL);
  ASSERT_TRUE(message) << message.error().message;
  EXPECT_EQ(message->header.utime, 1000);
  EXPECT_EQ(message->exposure_us, 5);
  EXPECT_EQ(static_cast<std::uint64_t>(message->calibration_id), 0xfeedfacecafebeefULL);
  const auto images = to_images(*message);
  ASSERT_TRUE(images);
  EXPECT_TRUE(equal(images->left, frame.left));
  EXPECT_TRUE(equal(images->right, frame.right));
}

TEST(ImageMessages, JpegComesBackAsOpenCvDecodesIt) {
  const camera::Frame frame = noisy_frame(0, 4);
  const auto message = FrameEncoder().encode(frame, 1);
  ASSERT_TRUE(message);
  const auto images = to_images(*message);
  ASSERT_TRUE(images);
  EXPECT_GT(cv::PSNR(images->left, frame.left), 34);
  EXPECT_GT(cv::PSNR(images->right, frame.right), 34);
  const cv::Mat peer = cv::imdecode(message->left, cv::IMREAD_GRAYSCALE);
  EXPECT_LE(cv::norm(peer, images->left, cv::NORM_INF), 1);
}

TEST(FrameEncoder, EveryFrameFitsTheBudgetAndTheQualityComesBack) {
  FrameEncoder encoder;
  int lowest = 100;
  for (int i = 0; i < 60; ++i) {
    const double noise = i < 20 ? 3 : i < 30 ? 40 : 3;
    const auto message = encoder.encode(noisy_frame(i, noise), 1);
    ASSERT_TRUE(message) << message.error().message;
    EXPECT_LE(message->getEncodedSize(), FrameEncoder::kDefaultBudget_bytes);
    EXPECT_GE(message->jpeg_quality, FrameEncoder::kMinQuality);
    lowest = std::min<int>(lowest, message->jpeg_quality);
  }
  EXPECT_LT(lowest, 60);
  EXPECT_GT(encoder.quality(), 60);
}

TEST(FrameEncoder, ARestartedOneGoesOnAsIfNothingHadHappened) {
  FrameEncoder first;
  for (int i = 0; i < 6; ++i) ASSERT_TRUE(first.encode(noisy_frame(i, 25), 1));
  FrameEncoder second;
  second.set_quality(first.quality());
  for (int i = 6; i < 12; ++i) {
    const double noise = i < 9 ? 25 : 5;
    const auto a = first.encode(noisy_frame(i, noise), 1);
    const auto b = second.encode(noisy_frame(i, noise), 1);
    EXPECT_EQ(a->left, b->left);
    EXPECT_EQ(a->right, b->right);
    EXPECT_EQ(a->jpeg_quality, b->jpeg_quality);
  }
}

TEST(FrameEncoder, ASetQualityIsHeldWithinItsLimits) {
  FrameEncoder encoder;
  encoder.set_quality(200);
  EXPECT_EQ(encoder.quality(), FrameEncoder::kMaxQuality);
  encoder.set_quality(-3);
  EXPECT_EQ(encoder.quality(), FrameEncoder::kMinQuality);
}

TEST(FrameEncoder, WhatCannotFitIsRefusedWithSizesAndAWayOut) {
  const auto raw = FrameEncoder(ImageEncoding::kRaw).encode(noisy_frame(0, 3), 1);
  ASSERT_FALSE(raw);
  EXPECT_EQ(raw.error().message,
            "STEREO_FRAME: two raw images of 640x480 need 614474 bytes, the budget is 115000; send "
            "JPEG, smaller images, or raise the budget");
  FrameEncoder encoder(ImageEncoding::kJpeg, 20'000);
  const auto jpeg = encoder.encode(noisy_frame(0, 80), 1);
  ASSERT_FALSE(jpeg);
  EXPECT_NE(jpeg.error().message.find("at the lowest JPEG quality (20), the budget is 20000"),
            std::string::npos);
  EXPECT_TRUE(encoder.encode(noisy_frame(1, 0, {320, 240}), 1)) << "it stays usable";
}

TEST(FrameEncoder, ImagesThatAreNoPairAreRefused) {
  camera::Frame frame = noisy_frame(0, 3);
  frame.right = frame.right.rowRange(0, 470);
  EXPECT_EQ(FrameEncoder().encode(frame, 1).error().message,
            "STEREO_FRAME: left image is 640x480, right 640x470");
  cv::cvtColor(frame.left, frame.right, cv::COLOR_GRAY2BGR);
  EXPECT_FALSE(FrameEncoder().encode(frame, 1));
  EXPECT_FALSE(FrameEncoder().encode(camera::Frame{}, 1));
  frame.left = frame.right = cv::Mat(1, 4097, CV_8UC1);
  EXPECT_FALSE(FrameEncoder().encode(frame, 1));
}

TEST(ImageMessages, DamagedOrForeignImagesAreRefused) {
  const stereo_frame_t good = FrameEncoder().encode(noisy_frame(0, 4), 1).value();
  ASSERT_EQ(error_of(good), "none");
  stereo_frame_t bad = good;
  bad.right.resize(bad.right.size() / 2);
  EXPECT_NE(error_of(bad).find("STEREO_FRAME right: "), std::string::npos) << error_of(bad);
  bad = good;
  bad.left.resize(bad.left.size() - 2);
  EXPECT_NE(error_of(bad).find("STEREO_FRAME left: "), std::string::npos) << error_of(bad);
  bad = good;
  bad.left.clear();
  EXPECT_NE(error_of(bad).find("STEREO_FRAME left: "), std::string::npos) << error_of(bad);
  bad = good;
  bad.width_px = 639;
  EXPECT_EQ(error_of(bad), "STEREO_FRAME left: JPEG is 640x480, message says 639x480");
  bad = good;
  bad.height_px = 5000;
  EXPECT_EQ(error_of(bad), "STEREO_FRAME: image size 640x5000 is out of range");
  bad = good;
  bad.encoding = 9;
  EXPECT_EQ(error_of(bad), "STEREO_FRAME encoding: 9 is unknown");
  bad = good;
  bad.encoding = stereo_frame_t::ENCODING_RAW;
  EXPECT_NE(error_of(bad).find("the stated size needs 307200"), std::string::npos);
  bad = good;
  cv::imencode(".jpg", cv::Mat(480, 640, CV_8UC3, cv::Scalar(1, 200, 3)), bad.right);
  EXPECT_EQ(error_of(bad), "STEREO_FRAME right: JPEG is not grey");
  bad = good;
  cv::imencode(".png", cv::Mat(480, 640, CV_8UC1, cv::Scalar(1)), bad.right);
  EXPECT_NE(error_of(bad).find("STEREO_FRAME right: "), std::string::npos);
}

struct Pair {
  std::string name;
  std::string left;
  std::string right;
};

TEST(ImageMessages, QualityAndTimeOnRealPairs) {
  const auto data = testing::data_folder();
  if (!data) GTEST_SKIP() << "no real images: set CAIRN_DATA";
  const std::vector<Pair> pairs{
      {"kitti_1 1226x370", "sequence/kitti_1/image_l/000000.png",
       "sequence/kitti_1/image_r/000000.png"},
      {"adirondack 720x497", "stereo/gt/adirondack/left.png", "stereo/gt/adirondack/right.png"},
      {"motorcycle 640x480", "stereo/gt/motorcycle/left.png", "stereo/gt/motorcycle/right.png"}};
  for (const Pair& pair : pairs) {
    camera::Frame frame;
    frame.left = cv::imread(*data / pair.left, cv::IMREAD_GRAYSCALE);
    frame.right = cv::imread(*data / pair.right, cv::IMREAD_GRAYSCALE);
    if (frame.left.empty()) continue;
    if (pair.name.find("640x480") != std::string::npos) {
      frame.left = frame.left(cv::Rect(0, 0, 640, 480)).clone();
      frame.right = frame.right(cv::Rect(0, 0, 640, 480)).clone();
    }
    FrameEncoder encoder;
    Result<stereo_frame_t> message;
    for (int i = 0; i < 20; ++i) message = encoder.encode(frame, 1);
    ASSERT_TRUE(message) << message.error().message;
    const auto start = std::chrono::steady_clock::now();
    (void)encoder.encode(frame, 1);
    const auto encoded = std::chrono::steady_clock::now();
    const auto images = to_images(*message);
    const auto decoded = std::chrono::steady_clock::now();
    ASSERT_TRUE(images);
    using Milliseconds = std::chrono::duration<double, std::milli>;
    std::printf("%s: quality %d, %d bytes, PSNR %.1f dB, encode %.1f ms, decode %.1f ms\n",
                pair.name.c_str(), message->jpeg_quality, message->getEncodedSize(),
                cv::PSNR(images->left, frame.left), Milliseconds(encoded - start).count(),
                Milliseconds(decoded - encoded).count());
  }
}

}  // namespace
}  // namespace cairn::messages
