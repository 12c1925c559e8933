// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "stereo/depth_noise.hpp"
#include "stereo/depth_to_disparity.hpp"
#include "stereo/disparity_image.hpp"

namespace cairn::stereo {
namespace {

RectifiedCamera robot_camera() {
  RectifiedCamera camera;
  camera.f_px = 554;
  camera.cx_px = 319.5;
  camera.cy_px = 239.5;
  camera.baseline_m = 0.254;
  camera.width_px = 640;
  camera.height_px = 480;
  return camera;
}

DisparityImage one_answer(const RectifiedCamera& camera, int row, int col, double disparity_px) {
  DisparityImage image;
  image.step_px = 2;
  image.camera = camera;
  image.disparity_16ths = cv::Mat_<std::uint16_t>::zeros(240, 320);
  image.code = cv::Mat_<std::uint8_t>::zeros(240, 320);
  image.disparity_16ths(row, col) = static_cast<std::uint16_t>(std::lround(16 * disparity_px));
  return image;
}

TEST(Depth, IsFocalLengthTimesBaselineOverDisparity) {
  const auto image = one_answer(robot_camera(), 10, 20, 28);
  EXPECT_DOUBLE_EQ(image.depth_m(10, 20), 554 * 0.254 / 28);
}

TEST(Depth, CountsTheOffsetBetweenThePrincipalPoints) {
  RectifiedCamera camera = robot_camera();
  camera.doffs_px = 31.0625;
  EXPECT_DOUBLE_EQ(one_answer(camera, 0, 0, 8).depth_m(0, 0), 554 * 0.254 / 39.0625);
  camera.doffs_px = -8;
  EXPECT_EQ(one_answer(camera, 0, 0, 8).depth_m(0, 0), std::numeric_limits<double>::infinity());
}

TEST(Depth, PointProjectsBackOntoItsPixel) {
  const RectifiedCamera camera = robot_camera();
  const auto p = one_answer(camera, 100, 33, 61.5).point_camera(100, 33);
  EXPECT_NEAR(camera.f_px * p.x() / p.z() + camera.cx_px, 66, 1e-9);
  EXPECT_NEAR(camera.f_px * p.y() / p.z() + camera.cy_px, 200, 1e-9);
  EXPECT_NEAR(camera.f_px * camera.baseline_m / p.z(), 61.5, 1e-9);
}

TEST(Depth, SigmaIsTheSlopeOfDepthOverDisparity) {
  const RectifiedCamera camera = robot_camera();
  const double fb = camera.f_px * camera.baseline_m;
  for (const double z_m : {0.7, 2.2, 4.3, 9.0}) {
    const double d_px = fb / z_m;
    const double slope = (fb / (d_px - 1e-4) - fb / (d_px + 1e-4)) / 2e-4;
    EXPECT_NEAR(depth_sigma_m(camera, z_m, 0.3), 0.3 * slope, 1e-6);
  }
  EXPECT_NEAR(depth_sigma_m(camera, 2.2, 0.3), 0.0103, 1e-4);
}

TEST(DepthToDisparity, ComesBackWithinTheRoundingOfASixteenth) {
  const RectifiedCamera camera = robot_camera();
  cv::Mat_<float> depth_m(480, 640);
  for (int row = 0; row < 480; ++row) {
    for (int col = 0; col < 640; ++col) {
      depth_m(row, col) = 0.5F + 0.01F * static_cast<float>(col) + 0.004F * static_cast<float>(row);
    }
  }
  for (const int step_px : {1, 2, 3}) {
    const auto image = disparity_from_depth(depth_m, camera, step_px, 77);
    ASSERT_TRUE(image);
    EXPECT_EQ(image->utime, 77);
    EXPECT_EQ(image->cols(), (640 + step_px - 1) / step_px);
    for (int row = 0; row < image->rows(); ++row) {
      for (int col = 0; col < image->cols(); ++col) {
        const double z_m = static_cast<double>(depth_m(row * step_px, col * step_px));
        ASSERT_TRUE(image->valid(row, col));
        ASSERT_NEAR(image->disparity_px(row, col), 554 * 0.254 / z_m, 1.0 / 32 + 1e-9);
        ASSERT_NEAR(image->depth_m(row, col), z_m, 1.05 * depth_sigma_m(camera, z_m, 1.0 / 32));
      }
    }
  }
}

TEST(DepthToDisparity, TellsWhyThereIsNoAnswer) {
  RectifiedCamera camera = robot_camera();
  camera.width_px = 4;
  camera.height_px = 1;
  camera.doffs_px = 20;
  const cv::Mat_<float> depth_m =
      (cv::Mat_<float>(1, 4) << 0, std::numeric_limits<float>::quiet_NaN(), 100, 2);
  const auto image = disparity_from_depth(depth_m, camera, 1, 0);
  ASSERT_TRUE(image);
  EXPECT_EQ(image->code(0, 0), static_cast<int>(Reason::kNoData));
  EXPECT_EQ(image->code(0, 1), static_cast<int>(Reason::kNoData));
  EXPECT_EQ(image->code(0, 2), static_cast<int>(Reason::kOutOfRange));
  EXPECT_TRUE(image->valid(0, 3));
}

TEST(DepthToDisparity, RefusesWhatDoesNotFit) {
  const RectifiedCamera camera = robot_camera();
  EXPECT_FALSE(disparity_from_depth(cv::Mat(), camera, 1, 0));
  EXPECT_FALSE(disparity_from_depth(cv::Mat::zeros(480, 640, CV_16UC1), camera, 1, 0));
  EXPECT_FALSE(disparity_from_depth(cv::Mat::zeros(480, 639, CV_32FC1), camera, 1, 0));
  EXPECT_FALSE(disparity_from_depth(cv::Mat::zeros(480, 640, CV_32FC1), camera, 0, 0));
}

}  // namespace
}  // namespace cairn::stereo
