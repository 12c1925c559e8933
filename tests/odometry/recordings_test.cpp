// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "camera/rig_calibration.hpp"
#include "data_folder.hpp"
#include "odometry/stereo_odometry.hpp"
#include "stereo/rectifier.hpp"

namespace cairn::odometry {
namespace {

constexpr double kDegrees = 180 / 3.14159265358979;
constexpr std::size_t kFrameBudgetBytes = 115'000;

std::vector<std::filesystem::path> images_in(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> files;
  for (const auto& file : std::filesystem::directory_iterator(folder)) files.push_back(file.path());
  std::sort(files.begin(), files.end());
  return files;
}

cv::Mat read_grey(const std::filesystem::path& path) {
  return cv::imread(path.string(), cv::IMREAD_GRAYSCALE);
}

std::vector<Isometry> read_poses(const std::filesystem::path& path) {
  std::ifstream file(path);
  std::vector<Isometry> poses;
  while (true) {
    Isometry T = Isometry::Identity();
    for (int row = 0; row < 3; ++row) {
      for (int col = 0; col < 4; ++col) file >> T.matrix()(row, col);
    }
    if (!file) return poses;
    poses.push_back(T);
  }
}

/// Both images as they come over a bus that takes only so many bytes a frame: the best JPEG quality
/// that fits.
std::size_t squeeze(cv::Mat& left, cv::Mat& right) {
  for (int quality = 95; quality >= 5; quality -= 5) {
    std::vector<std::uint8_t> jpeg[2];
    cv::imencode(".jpg", left, jpeg[0], {cv::IMWRITE_JPEG_QUALITY, quality});
    cv::imencode(".jpg", right, jpeg[1], {cv::IMWRITE_JPEG_QUALITY, quality});
    const std::size_t bytes = jpeg[0].size() + jpeg[1].size();
    if (bytes > kFrameBudgetBytes) continue;
    left = cv::imdecode(jpeg[0], cv::IMREAD_GRAYSCALE);
    right = cv::imdecode(jpeg[1], cv::IMREAD_GRAYSCALE);
    return bytes;
  }
  return 0;
}

stereo::RectifiedCamera street_camera() {
  stereo::RectifiedCamera camera;
  camera.f_px = 707.0912;
  camera.cx_px = 601.8873;
  camera.cy_px = 183.1104;
  camera.baseline_m = 0.537151;
  camera.width_px = 1226;
  camera.height_px = 370;
  return camera;
}

class Street : public ::testing::TestWithParam<bool> {};

TEST_P(Street, EndsWithinTwoPercentOfTheWay) {
  const auto data = testing::data_folder();
  if (!data) GTEST_SKIP() << "the real recordings are not here; set CAIRN_DATA";
  const auto folder = *data / "sequence" / "kitti_1";
  const auto truth = read_poses(folder / "poses.txt");
  const auto left_files = images_in(folder / "image_l");
  const auto right_files = images_in(folder / "image_r");
  ASSERT_EQ(truth.size(), left_files.size());

  StereoOdometry odometry{StereoOdometryConfig{}};
  OdometryEstimate estimate;
  double way_m = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    cv::Mat left = read_grey(left_files[i]);
    cv::Mat right = read_grey(right_files[i]);
    if (GetParam()) {
      ASSERT_GT(squeeze(left, right), 0U);
    }
    const auto result =
        odometry.update(left, right, street_camera(), static_cast<Utime>(i) * 100'000);
    ASSERT_TRUE(result) << result.error().message;
    EXPECT_FALSE(result->coasting && i > 0) << i;
    estimate = *result;
    if (i > 0) way_m += (truth[i].translation() - truth[i - 1].translation()).norm();
  }
  const Isometry error = (truth.front().inverse() * truth.back()).inverse() * estimate.T_odom_body;
  std::printf(
      "street, %s: %.1f m, end %.2f %% off, turned by %.2f degrees (yaw %.2f)\n",
      GetParam() ? "JPEG within 115 kB" : "raw", way_m, 100 * error.translation().norm() / way_m,
      kDegrees * rotation_angle_rad(error.linear()), kDegrees * log_so3(error.linear()).y());
  EXPECT_LT(error.translation().norm(), 0.02 * way_m);
}

INSTANTIATE_TEST_SUITE_P(Recordings, Street, ::testing::Bool(), [](const auto& parameter) {
  return parameter.param ? std::string("Jpeg") : std::string("Raw");
});

camera::RigCalibration still_rig() {
  camera::RigCalibration rig;
  rig.width_px = 752;
  rig.height_px = 480;
  rig.left = {458.654,
              457.296,
              367.215,
              248.375,
              camera::Distortion::kRadialTangential,
              {-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05}};
  rig.right = {457.587,
               456.134,
               379.999,
               255.238,
               camera::Distortion::kRadialTangential,
               {-0.28368365, 0.07451284, -0.00010473, -3.55590700e-05}};
  Isometry T_body_right = Isometry::Identity();
  rig.T_body_left.matrix() << 0.0148655429818, -0.999880929698, 0.00414029679422, -0.0216401454975,
      0.999557249008, 0.0149672133247, 0.025715529948, -0.064676986768, -0.0257744366974,
      0.00375618835797, 0.999660727178, 0.00981073058949, 0, 0, 0, 1;
  T_body_right.matrix() << 0.0125552670891, -0.999755099723, 0.0182237714554, -0.0198435579556,
      0.999598781151, 0.0130119051815, 0.0251588363115, 0.0453689425024, -0.0253898008918,
      0.0179005838253, 0.999517347078, 0.00786212447038, 0, 0, 0, 1;
  rig.T_body_left.linear() = nearest_rotation(rig.T_body_left.linear());
  T_body_right.linear() = nearest_rotation(T_body_right.linear());
  rig.T_right_left = T_body_right.inverse() * rig.T_body_left;
  return rig;
}

TEST(Recordings, ARealRigThatStandsStillStaysWhereItIs) {
  const auto data = testing::data_folder();
  if (!data) GTEST_SKIP() << "the real recordings are not here; set CAIRN_DATA";
  const auto folder = *data / "sequence" / "euroc_v101_static";
  const auto rectifier = stereo::Rectifier::create(still_rig());
  ASSERT_TRUE(rectifier) << rectifier.error().message;
  StereoOdometry odometry{StereoOdometryConfig{}};
  double farthest_m = 0;
  double farthest_rad = 0;
  const auto files = images_in(folder / "cam0");
  for (std::size_t i = 0; i < files.size(); ++i) {
    const auto pair =
        rectifier->rectify(read_grey(files[i]), read_grey(folder / "cam1" / files[i].filename()));
    ASSERT_TRUE(pair);
    const auto estimate = odometry.update(pair->left, pair->right, rectifier->camera(),
                                          static_cast<Utime>(i) * 50'000);
    ASSERT_TRUE(estimate);
    EXPECT_FALSE(estimate->coasting);
    farthest_m = std::max(farthest_m, estimate->T_odom_body.translation().norm());
    farthest_rad = std::max(farthest_rad, rotation_angle_rad(estimate->T_odom_body.linear()));
  }
  std::printf("standing still, %zu frames: at most %.2f mm and %.3f degrees off\n", files.size(),
              1000 * farthest_m, kDegrees * farthest_rad);
  // The truth itself moves by under 3 mm.
  EXPECT_LT(farthest_m, 0.004);
  EXPECT_LT(farthest_rad, 0.003);
}

}  // namespace
}  // namespace cairn::odometry
