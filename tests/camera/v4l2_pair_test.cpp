// SPDX-License-Identifier: Apache-2.0
#include "camera/v4l2_pair.hpp"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "camera/fake_v4l2.hpp"
#include "camera/scratch.hpp"

namespace cairn::camera {
namespace {

using testing::FakeCamera;
using testing::FakeClock;
using testing::FakeV4l2Device;

constexpr std::int64_t kOffset_us = 1'000'000'000;
constexpr std::int64_t kPeriod_us = 33'333;

class V4l2Pairs : public ::testing::Test {
 protected:
  V4l2Pairs() {
    for (const auto& camera : {left_, right_}) camera->clock = clock_;
    config_.left_device = "/dev/left";
    config_.right_device = "/dev/right";
    config_.width_px = 8;
    config_.height_px = 4;
  }

  void plug_in() {
    auto pair = V4l2Pair::create(
        config_, rectified_rig(8, 8, 4, 2, 0.1, 8, 4, Isometry::Identity()),
        std::make_unique<FakeV4l2Device>(left_), std::make_unique<FakeV4l2Device>(right_),
        [clock = clock_] { return clock->now; }, kOffset_us);
    ASSERT_TRUE(pair) << pair.error().message;
    pair_ = std::move(*pair);
  }
  /// Both cameras shoot `count` images, from `start` on, the right one `skew_us` later, grey at 10,
  /// 11, ...
  void shoot(int count, HostTime start, std::int64_t skew_us = 0) {
    for (int i = 0; i < count; ++i) {
      left_->shoot(start + i * kPeriod_us, static_cast<std::uint8_t>(10 + i));
      right_->shoot(start + i * kPeriod_us + skew_us, static_cast<std::uint8_t>(100 + i));
    }
  }
  [[nodiscard]] std::string error() const {
    const auto frame = pair_->next();
    return frame ? "" : frame.error().message;
  }
  static bool names(const std::string& message, const std::string& part) {
    return message.find(part) != std::string::npos;
  }

  std::shared_ptr<FakeClock> clock_ = std::make_shared<FakeClock>();
  std::shared_ptr<FakeCamera> left_ = std::make_shared<FakeCamera>();
  std::shared_ptr<FakeCamera> right_ = std::make_shared<FakeCamera>();
  V4l2Config config_;
  std::unique_ptr<V4l2Pair> pair_;
};

TEST_F(V4l2Pairs, ImagesTakenTogetherArePairsWithTheKernelsTime) {
  left_->row_padding_bytes = 6;
  plug_in();
  shoot(10, 5'100'000, 1'200);
  for (int i = 0; i < 10; ++i) {
    const auto frame = pair_->next();
    ASSERT_TRUE(frame) << frame.error().message;
    EXPECT_EQ(frame->index, i);
    EXPECT_EQ(frame->utime, 5'100'000 + i * kPeriod_us + kOffset_us);
    EXPECT_TRUE(testing::same_bytes(frame->left, cv::Mat(4, 8, CV_8UC1, cv::Scalar(10 + i))));
    EXPECT_TRUE(testing::same_bytes(frame->right, cv::Mat(4, 8, CV_8UC1, cv::Scalar(100 + i))));
    EXPECT_EQ(frame->exposure_us, 10'000);
  }
  EXPECT_EQ(pair_->skew_refused(), 0);
  EXPECT_FALSE(pair_->finished());
  EXPECT_FALSE(pair_->size());
  EXPECT_EQ(left_->opened, 1);
}

TEST_F(V4l2Pairs, OneEyeLateIsDroppedCountedAndBackInStep) {
  plug_in();
  shoot(2, 5'100'000);
  right_->shots.pop_back();  // the right eye loses one image
  shoot(3, 5'100'000 + 2 * kPeriod_us);
  EXPECT_EQ(pair_->next()->utime, 5'100'000 + kOffset_us);
  const auto next = pair_->next();
  ASSERT_TRUE(next) << next.error().message;
  EXPECT_EQ(next->utime, 5'100'000 + 2 * kPeriod_us + kOffset_us);
  EXPECT_EQ(pair_->skew_refused(), 1);
  EXPECT_EQ(next->index, 1);
  EXPECT_TRUE(pair_->next());
  EXPECT_EQ(pair_->skew_refused(), 1);
}

TEST_F(V4l2Pairs, EyesThatStayApartAreAnErrorThatSaysHowFar) {
  config_.timeout_ms = 1000;
  plug_in();
  shoot(60, 5'100'000, 16'000);
  const std::string message = error();
  EXPECT_TRUE(names(message, "ms apart, max_skew_ms is 5.0 ms")) << message;
  EXPECT_EQ(pair_->skew_refused(), 8);
  EXPECT_EQ(left_->opened, 1) << "both cameras are well: nothing is opened anew";
  config_.max_skew_ms = 20;
  plug_in();
  EXPECT_TRUE(pair_->next()) << "what the config allows is a pair";
}

TEST_F(V4l2Pairs, SkewAtTheLimitIsAPairAndJustBeyondIsNot) {
  plug_in();
  shoot(1, 5'100'000, 5'000);
  shoot(1, 5'200'000, 5'001);
  shoot(1, 5'300'000, 0);
  EXPECT_EQ(pair_->next()->utime, 5'100'000 + kOffset_us);
  EXPECT_EQ(pair_->next()->utime, 5'300'000 + kOffset_us);
  EXPECT_EQ(pair_->skew_refused(), 2);
}

TEST_F(V4l2Pairs, UnpluggedAndBackGoesOnWithoutARestartAndLeaksNothing) {
  plug_in();
  shoot(1, 5'100'000);
  ASSERT_TRUE(pair_->next());
  right_->shots.push_back({5'130'000, {}, 0, ENODEV});
  left_->shoot(5'130'000, 1);
  EXPECT_TRUE(names(error(), "right camera /dev/right: VIDIOC_DQBUF: No such device"));
  right_->plugged_in = false;
  for (int i = 0; i < 3; ++i) {
    EXPECT_TRUE(names(error(), "right camera /dev/right: open: No such device"));
    clock_->now += 500'000;
  }
  right_->plugged_in = true;
  left_->shots.clear();
  shoot(2, clock_->now + 50'000);
  const auto frame = pair_->next();
  ASSERT_TRUE(frame) << frame.error().message;
  EXPECT_EQ(frame->index, 1);
  pair_.reset();
  for (const auto& camera : {left_, right_}) {
    EXPECT_EQ(camera->opened, camera->closed);
    EXPECT_EQ(camera->mapped, camera->unmapped);
    EXPECT_GT(camera->mapped, 0);
  }
}

TEST_F(V4l2Pairs, AnInputErrorReopensBoth) {
  plug_in();
  shoot(1, 5'100'000);
  ASSERT_TRUE(pair_->next());
  left_->shots.push_back({5'130'000, {}, 0, EIO});
  EXPECT_TRUE(names(error(), "left camera /dev/left: VIDIOC_DQBUF: Input/output error"));
  right_->shots.clear();
  shoot(1, clock_->now + 50'000);
  EXPECT_TRUE(pair_->next());
  EXPECT_EQ(left_->opened, 2);
  EXPECT_EQ(right_->opened, 2);
}

TEST_F(V4l2Pairs, AFrozenCameraIsFlaggedInTimeAndComesBack) {
  plug_in();
  shoot(1, 5'100'000);
  ASSERT_TRUE(pair_->next());
  left_->shoot(5'133'333, 11);
  const HostTime frozen_at = clock_->now;
  EXPECT_TRUE(names(error(), "right camera /dev/right: no image within 300 ms"));
  EXPECT_LE(clock_->now - frozen_at, 500'000);
  EXPECT_EQ(right_->closed, 1);
  shoot(1, clock_->now + 900'000);
  // Webcams take long to start: that is not frozen again, and nothing is opened over and over.
  EXPECT_TRUE(names(error(), "no image yet since it was opened"));
  EXPECT_TRUE(names(error(), "no image yet since it was opened"));
  Result<Frame> frame = pair_->next();
  for (int i = 0; i < 3 && !frame; ++i) frame = pair_->next();
  ASSERT_TRUE(frame) << frame.error().message;
  EXPECT_EQ(right_->opened, 2);
  EXPECT_LE(clock_->now - frozen_at, 3'000'000);
}

TEST_F(V4l2Pairs, ACameraThatNeverStartsIsOpenedAnewAfterItsTime) {
  plug_in();
  for (int i = 0; i < 20; ++i) EXPECT_FALSE(pair_->next());
  EXPECT_GE(left_->opened, 2);
  EXPECT_LE(left_->opened, 3);
}

TEST_F(V4l2Pairs, HalfAnImageIsRefusedAndTheNextOneComes) {
  plug_in();
  shoot(3, 5'100'000);
  left_->shots[1].bytes.resize(left_->shots[1].bytes.size() / 2);
  ASSERT_TRUE(pair_->next());
  const std::string message = error();
  EXPECT_TRUE(names(message, "left camera /dev/left: half an image: 32 of 64 bytes")) << message;
  const auto next = pair_->next();
  ASSERT_TRUE(next);
  EXPECT_EQ(next->utime, 5'100'000 + 2 * kPeriod_us + kOffset_us);
  EXPECT_EQ(left_->opened, 1);
}

TEST_F(V4l2Pairs, ABufferMarkedDamagedIsRefused) {
  plug_in();
  shoot(2, 5'100'000);
  right_->shots[0].flags |= V4L2_BUF_FLAG_ERROR;
  EXPECT_TRUE(names(error(), "right camera /dev/right: the driver marks an image as damaged"));
  EXPECT_TRUE(pair_->next());
}

TEST_F(V4l2Pairs, MjpgIsDecodedAndCutOnesAreRefused) {
  const cv::Mat image = testing::noise_image(5, CV_8UC1, {8, 4});
  std::vector<std::uint8_t> jpeg;
  cv::imencode(".jpg", image, jpeg);
  const cv::Mat expected = cv::imdecode(jpeg, cv::IMREAD_GRAYSCALE);
  for (const auto& camera : {left_, right_})
    camera->formats = {V4L2_PIX_FMT_H264, V4L2_PIX_FMT_MJPEG};
  plug_in();
  for (int i = 0; i < 3; ++i) {
    for (const auto& camera : {left_, right_})
      camera->shots.push_back({5'100'000 + i * kPeriod_us, jpeg});
  }
  left_->shots[1].bytes.resize(jpeg.size() - 20);
  right_->shots[2].bytes.resize(jpeg.size() + 64);  // webcams fill up with zeros
  const auto frame = pair_->next();
  ASSERT_TRUE(frame) << frame.error().message;
  EXPECT_TRUE(testing::same_bytes(frame->left, expected));
  EXPECT_TRUE(names(error(), "left camera /dev/left: an image is cut off"));
  EXPECT_TRUE(pair_->next());
}

TEST_F(V4l2Pairs, NoCutOrDamageOfAnMjpgImageDoesHarm) {
  std::vector<std::uint8_t> jpeg;
  cv::imencode(".jpg", testing::noise_image(5, CV_8UC1, {8, 4}), jpeg);
  for (const auto& camera : {left_, right_}) camera->formats = {V4L2_PIX_FMT_MJPEG};
  plug_in();
  constexpr std::uint32_t kSeed = 7;
  std::printf("seed %u\n", kSeed);
  std::mt19937 rng(kSeed);
  int refused = 0;
  for (int i = 0; i < 2000; ++i) {
    const HostTime at = 5'100'000 + i * kPeriod_us;
    const std::string bytes = testing::corrupted({jpeg.begin(), jpeg.end()}, rng);
    left_->shots.push_back({at, {bytes.begin(), bytes.end()}});
    right_->shots.push_back({at, jpeg});
    const auto frame = pair_->next();
    if (frame) {
      ASSERT_EQ(frame->left.size(), cv::Size(8, 4));
    }
    refused += frame ? 0 : 1;
  }
  EXPECT_GT(refused, 100);
  EXPECT_EQ(left_->opened, 1);
}

TEST_F(V4l2Pairs, AWrongFormatNamesWhatIsOffered) {
  right_->formats = {V4L2_PIX_FMT_H264, V4L2_PIX_FMT_NV12};
  plug_in();
  const std::string message = error();
  EXPECT_TRUE(names(message, "right camera /dev/right: no format fits")) << message;
  EXPECT_TRUE(names(message, "H264 NV12")) << message;
  right_->formats = {V4L2_PIX_FMT_YUYV};
  right_->width_px = 16;
  EXPECT_TRUE(names(error(), "8 x 4 pixels; the driver offers YUYV, or not at this size"));
}

TEST_F(V4l2Pairs, TheConfigChoosesAmongTheFormats) {
  for (const auto& camera : {left_, right_}) {
    camera->formats = {V4L2_PIX_FMT_MJPEG, V4L2_PIX_FMT_YUYV, V4L2_PIX_FMT_GREY};
  }
  plug_in();
  for (const auto& camera : {left_, right_}) {
    camera->shots.push_back({5'100'000, std::vector<std::uint8_t>(32, 77)});
  }
  const auto frame = pair_->next();
  ASSERT_TRUE(frame) << frame.error().message << ": of all three, grey comes first";
  EXPECT_TRUE(testing::same_bytes(frame->left, cv::Mat(4, 8, CV_8UC1, cv::Scalar(77))));
  config_.format = "yuyv";
  plug_in();
  shoot(1, clock_->now + 50'000);
  EXPECT_TRUE(pair_->next());
}

TEST_F(V4l2Pairs, ExposureAndWhiteBalanceAreLockedWhereTheDriverHasThem) {
  config_.exposure_us = 8'000;
  config_.white_balance_k = 5'000;
  config_.gain = 12;
  right_->controls = {{V4L2_CID_EXPOSURE_AUTO, {0, 3, 3}}};
  plug_in();
  shoot(1, 5'100'000);
  const auto frame = pair_->next();
  ASSERT_TRUE(frame) << frame.error().message;
  EXPECT_EQ(frame->exposure_us, 8'000);
  EXPECT_EQ(left_->controls[V4L2_CID_EXPOSURE_AUTO].value, V4L2_EXPOSURE_MANUAL);
  EXPECT_EQ(left_->controls[V4L2_CID_EXPOSURE_AUTO_PRIORITY].value, 0);
  EXPECT_EQ(left_->controls[V4L2_CID_EXPOSURE_ABSOLUTE].value, 80);
  EXPECT_EQ(left_->controls[V4L2_CID_AUTO_WHITE_BALANCE].value, 0);
  EXPECT_EQ(left_->controls[V4L2_CID_WHITE_BALANCE_TEMPERATURE].value, 5'000);
  EXPECT_EQ(left_->controls[V4L2_CID_GAIN].value, 12);
  EXPECT_EQ(right_->controls[V4L2_CID_EXPOSURE_AUTO].value, V4L2_EXPOSURE_MANUAL);
}

TEST_F(V4l2Pairs, ARefusedControlNamesDeviceAndControl) {
  right_->controls[V4L2_CID_AUTO_WHITE_BALANCE].refusal = EBUSY;
  plug_in();
  EXPECT_EQ(error(),
            "right camera /dev/right: white_balance_automatic = 0: Device or resource busy");
  right_->controls[V4L2_CID_AUTO_WHITE_BALANCE].refusal = 0;
  right_->controls[V4L2_CID_EXPOSURE_ABSOLUTE].maximum = 50;
  EXPECT_EQ(
      error(),
      "right camera /dev/right: exposure_time_absolute: 100 is wanted, the driver allows 3 to 50");
}

TEST_F(V4l2Pairs, EveryStepThatTheDriverRefusesIsNamed) {
  plug_in();
  for (const auto& [request, step] :
       std::vector<std::pair<unsigned long, std::string>>{{VIDIOC_QUERYCAP, "VIDIOC_QUERYCAP"},
                                                          {VIDIOC_S_FMT, "VIDIOC_S_FMT YUYV"},
                                                          {VIDIOC_S_PARM, "VIDIOC_S_PARM"},
                                                          {VIDIOC_QUERYCTRL, "auto_exposure"},
                                                          {VIDIOC_S_CTRL, "auto_exposure = 1"},
                                                          {VIDIOC_G_CTRL, "exposure_time_absolute"},
                                                          {VIDIOC_REQBUFS, "VIDIOC_REQBUFS"},
                                                          {VIDIOC_QUERYBUF, "VIDIOC_QUERYBUF"},
                                                          {VIDIOC_QBUF, "VIDIOC_QBUF"},
                                                          {VIDIOC_STREAMON, "VIDIOC_STREAMON"}}) {
    left_->refusals = {{request, EIO}};
    const std::string message = error();
    EXPECT_TRUE(names(message, "left camera /dev/left: ")) << message;
    EXPECT_TRUE(names(message, step)) << message;
    EXPECT_TRUE(names(message, "Input/output error")) << message;
  }
  left_->refusals = {{VIDIOC_STREAMON, ENOSPC}};
  EXPECT_TRUE(names(error(), "USB controller has no bandwidth left"));
  left_->refusals.clear();
  shoot(1, clock_->now + 50'000);
  EXPECT_TRUE(pair_->next()) << "and it works once nothing is refused";
  EXPECT_EQ(left_->mapped, left_->unmapped + 4);
}

TEST_F(V4l2Pairs, TimesThatCannotBeTrustedAreRefused) {
  plug_in();
  shoot(5, 5'100'000);
  left_->shots[0].flags = 0;
  EXPECT_TRUE(
      names(error(), "left camera /dev/left: the driver does not stamp images with the monotonic"));
  left_->shots.clear();
  right_->shots.clear();
  shoot(1, clock_->now + 50'000);
  ASSERT_TRUE(pair_->next());
  shoot(1, clock_->now);  // the same time again
  EXPECT_TRUE(names(error(), "does not advance"));
  shoot(1, 1'000);  // since boot began
  EXPECT_TRUE(names(error(), "ms old"));
}

TEST_F(V4l2Pairs, AConfigThatDisagreesWithTheRigIsRefused) {
  const auto create = [this] {
    return V4l2Pair::create(
        config_, rectified_rig(8, 8, 4, 2, 0.1, 8, 4, Isometry::Identity()),
        std::make_unique<FakeV4l2Device>(left_), std::make_unique<FakeV4l2Device>(right_),
        [] { return HostTime{0}; }, 0);
  };
  config_.width_px = 640;
  EXPECT_TRUE(names(create().error().message, "width_px"));
  config_.width_px = 8;
  config_.right_device = config_.left_device;
  EXPECT_TRUE(names(create().error().message, "right_device"));
}

TEST(LinuxV4l2Device, WhatIsNoCameraIsRefusedByName) {
  V4l2Config config;
  for (const char* file : {"/dev/null", "/nowhere/video0"}) {
    V4l2Camera camera("left", file, config, linux_v4l2_device());
    const auto started = camera.start();
    ASSERT_FALSE(started);
    EXPECT_NE(started.error().message.find(std::string("left camera ") + file + ": "),
              std::string::npos)
        << started.error().message;
  }
}

}  // namespace
}  // namespace cairn::camera
