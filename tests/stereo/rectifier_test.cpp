// SPDX-License-Identifier: Apache-2.0
#include "stereo/rectifier.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>
#include <vector>

#include "data_folder.hpp"
#include "stereo/matcher.hpp"

namespace cairn::stereo {
namespace {

using camera::CameraModel;
using camera::Distortion;
using camera::RigCalibration;

RigCalibration euroc_rig() {
  RigCalibration rig;
  rig.width_px = 752;
  rig.height_px = 480;
  rig.left = {458.654,
              457.296,
              367.215,
              248.375,
              Distortion::kRadialTangential,
              {-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05}};
  rig.right = {457.587,
               456.134,
               379.999,
               255.238,
               Distortion::kRadialTangential,
               {-0.28368365, 0.07451284, -0.00010473, -3.55590700e-05}};
  Isometry T_body_left = Isometry::Identity();
  T_body_left.matrix() << 0.0148655429818, -0.999880929698, 0.00414029679422, -0.0216401454975,
      0.999557249008, 0.0149672133247, 0.025715529948, -0.064676986768, -0.0257744366974,
      0.00375618835797, 0.999660727178, 0.00981073058949, 0, 0, 0, 1;
  Isometry T_body_right = Isometry::Identity();
  T_body_right.matrix() << 0.0125552670891, -0.999755099723, 0.0182237714554, -0.0198435579556,
      0.999598781151, 0.0130119051815, 0.0251588363115, 0.0453689425024, -0.0253898008918,
      0.0179005838253, 0.999517347078, 0.00786212447038, 0, 0, 0, 1;
  T_body_left.linear() = nearest_rotation(T_body_left.linear());
  T_body_right.linear() = nearest_rotation(T_body_right.linear());
  rig.T_body_left = T_body_left;
  rig.T_right_left = T_body_right.inverse() * T_body_left;
  return rig;
}

RigCalibration crooked_rig(Distortion distortion, const Eigen::Vector3d& right_in_left_m) {
  RigCalibration rig;
  rig.width_px = 640;
  rig.height_px = 480;
  const std::vector<double> bend = distortion == Distortion::kNone ? std::vector<double>{}
                                   : distortion == Distortion::kEquidistant
                                       ? std::vector<double>{-0.01, 0.004, -0.002, 0.0005}
                                       : std::vector<double>{-0.2, 0.05, 0.001, -0.0005, 0.01};
  rig.left = {420, 424, 315, 244, distortion, bend};
  rig.right = {417, 419, 326, 236, distortion, bend};
  Isometry T_left_right = Isometry::Identity();
  T_left_right.linear() = rotation_from_rpy(0.02, -0.03, 0.015);
  T_left_right.translation() = right_in_left_m;
  rig.T_right_left = T_left_right.inverse();
  rig.T_body_left.linear() = rotation_from_rpy(0.1, 0.2, 0.3) * R_body_camera_forward();
  rig.T_body_left.translation() = Eigen::Vector3d(0.1, -0.2, 0.3);
  return rig;
}

/// Pinhole with distortion, straight from the papers' formulas.
Eigen::Vector2d raw_pixel(const CameraModel& camera, const Eigen::Vector3d& p) {
  const double x = p.x() / p.z();
  const double y = p.y() / p.z();
  double xd = x;
  double yd = y;
  const auto& k = camera.coefficients;
  const double r2 = x * x + y * y;
  if (camera.distortion == Distortion::kRadialTangential) {
    const double k3 = k.size() > 4 ? k[4] : 0;
    const double radial = 1 + r2 * (k[0] + r2 * (k[1] + r2 * k3));
    xd = x * radial + 2 * k[2] * x * y + k[3] * (r2 + 2 * x * x);
    yd = y * radial + k[2] * (r2 + 2 * y * y) + 2 * k[3] * x * y;
  } else if (camera.distortion == Distortion::kEquidistant) {
    const double r = std::sqrt(r2);
    const double a = std::atan(r);
    const double bent = a * (1 + k[0] * std::pow(a, 2) + k[1] * std::pow(a, 4) +
                             k[2] * std::pow(a, 6) + k[3] * std::pow(a, 8));
    xd = r > 0 ? x * bent / r : x;
    yd = r > 0 ? y * bent / r : y;
  }
  return {camera.fx_px * xd + camera.cx_px, camera.fy_px * yd + camera.cy_px};
}

cv::Mat draw_blob(cv::Size size, const Eigen::Vector2d& at_px) {
  cv::Mat_<std::uint8_t> image(size, std::uint8_t{0});
  for (int v = 0; v < size.height; ++v) {
    for (int u = 0; u < size.width; ++u) {
      const double r2 = std::pow(u - at_px.x(), 2) + std::pow(v - at_px.y(), 2);
      image(v, u) = static_cast<std::uint8_t>(std::lround(250 * std::exp(-r2 / 8)));
    }
  }
  return image;
}

Eigen::Vector2d centroid(const cv::Mat& image) {
  const cv::Moments m = cv::moments(image);
  return {m.m10 / m.m00, m.m01 / m.m00};
}

/// Points of the scene, drawn into raw images, must turn up in the rectified images where the
/// rectified camera says.
void expect_points_where_the_camera_says(const RigCalibration& rig) {
  const auto rectifier = Rectifier::create(rig);
  ASSERT_TRUE(rectifier) << rectifier.error().message;
  const RectifiedCamera& camera = rectifier->camera();
  const cv::Size size{rig.width_px, rig.height_px};
  int compared = 0;
  for (const double x : {-0.5, 0.0, 0.4}) {
    for (const double y : {-0.35, 0.1, 0.3}) {
      for (const double z_m : {1.0, 6.0}) {
        const Eigen::Vector3d in_left{x * z_m, y * z_m, z_m};
        const Eigen::Vector2d left_px = raw_pixel(rig.left, in_left);
        const Eigen::Vector2d right_px = raw_pixel(rig.right, rig.T_right_left * in_left);
        const Eigen::Vector3d p = camera.T_body_camera.inverse() * (rig.T_body_left * in_left);
        const double u = camera.f_px * p.x() / p.z() + camera.cx_px;
        const double v = camera.f_px * p.y() / p.z() + camera.cy_px;
        const double d = camera.f_px * camera.baseline_m / p.z() - camera.doffs_px;
        const auto inside = [](double a, double b, int width, int height) {
          return a > 20 && b > 20 && a < width - 21 && b < height - 21;
        };
        if (!inside(u, v, camera.width_px, camera.height_px) ||
            !inside(u - d, v, camera.width_px, camera.height_px) ||
            !inside(left_px.x(), left_px.y(), size.width, size.height) ||
            !inside(right_px.x(), right_px.y(), size.width, size.height)) {
          continue;
        }
        const auto pair = rectifier->rectify(draw_blob(size, left_px), draw_blob(size, right_px));
        ASSERT_TRUE(pair);
        EXPECT_EQ(pair->left.size(), cv::Size(camera.width_px, camera.height_px));
        EXPECT_LT((centroid(pair->left) - Eigen::Vector2d(u, v)).norm(), 0.08);
        EXPECT_LT((centroid(pair->right) - Eigen::Vector2d(u - d, v)).norm(), 0.08);
        ++compared;
      }
    }
  }
  EXPECT_GE(compared, 6);
}

TEST(Rectifier, PutsPointsWhereTheRectifiedCameraSays) {
  for (const auto distortion :
       {Distortion::kNone, Distortion::kRadialTangential, Distortion::kEquidistant}) {
    SCOPED_TRACE(static_cast<int>(distortion));
    expect_points_where_the_camera_says(crooked_rig(distortion, {0.254, 0.004, -0.006}));
  }
  expect_points_where_the_camera_says(euroc_rig());
}

TEST(Rectifier, TurnsAVerticalRigOnItsSide) {
  const auto rig = crooked_rig(Distortion::kRadialTangential, {0.004, 0.2, 0.003});
  expect_points_where_the_camera_says(rig);
  const auto rectifier = Rectifier::create(rig);
  ASSERT_TRUE(rectifier);
  EXPECT_EQ(rectifier->camera().width_px, 480);
  EXPECT_EQ(rectifier->camera().height_px, 640);
}

TEST(Rectifier, RectifiedVerticalRigToo) {
  auto rig = camera::rectified_rig(500, 500, 319.5, 239.5, 0.2, 640, 480, Isometry::Identity());
  rig.T_right_left.translation() = Eigen::Vector3d(0, -0.2, 0);
  expect_points_where_the_camera_says(rig);
}

TEST(Rectifier, LeavesNoPixelWithoutAPicture) {
  for (const auto& rig : {euroc_rig(), crooked_rig(Distortion::kNone, {0.254, 0.004, -0.006}),
                          crooked_rig(Distortion::kRadialTangential, {0.004, 0.2, 0.003}),
                          crooked_rig(Distortion::kEquidistant, {0.254, 0, 0})}) {
    const auto rectifier = Rectifier::create(rig);
    ASSERT_TRUE(rectifier);
    const cv::Mat white(rig.height_px, rig.width_px, CV_8UC1, cv::Scalar(255));
    const auto pair = rectifier->rectify(white, white);
    ASSERT_TRUE(pair);
    EXPECT_EQ(cv::countNonZero(pair->left != 255), 0);
    EXPECT_EQ(cv::countNonZero(pair->right != 255), 0);
  }
}

TEST(Rectifier, PassesARectifiedRigThrough) {
  auto rig = camera::rectified_rig(707.0912, 707.0912, 601.8873, 183.1104, 0.537151, 1226, 370,
                                   Isometry(Eigen::Translation3d(0, 0, 1.65)));
  rig.right.cx_px += 3.5;
  const auto rectifier = Rectifier::create(rig);
  ASSERT_TRUE(rectifier) << rectifier.error().message;
  EXPECT_TRUE(rectifier->passes_through());
  EXPECT_EQ(rectifier->camera().f_px, 707.0912);
  EXPECT_EQ(rectifier->camera().doffs_px, 3.5);
  EXPECT_EQ(rectifier->camera().baseline_m, 0.537151);
  EXPECT_EQ(rectifier->camera().T_body_camera.translation().z(), 1.65);
  const cv::Mat image = cv::Mat::ones(370, 1226, CV_8UC1);
  const auto pair = rectifier->rectify(image, image);
  ASSERT_TRUE(pair);
  EXPECT_EQ(pair->left.data, image.data);
}

TEST(Rectifier, RefusesRigsThatCannotBe) {
  const auto refused = [](auto&& change) {
    auto rig = crooked_rig(Distortion::kRadialTangential, {0.254, 0, 0});
    change(rig);
    const auto rectifier = Rectifier::create(rig);
    return !rectifier && !rectifier.error().message.empty();
  };
  EXPECT_FALSE(refused([](RigCalibration&) {}));
  EXPECT_TRUE(refused([](RigCalibration& r) { r = RigCalibration{}; }));
  EXPECT_TRUE(refused([](RigCalibration& r) { r.T_right_left.translation() *= -1; }));
  EXPECT_TRUE(refused([](RigCalibration& r) { r.T_right_left.translation().setZero(); }));
  EXPECT_TRUE(refused([](RigCalibration& r) { r.left.fx_px = std::nan(""); }));
  EXPECT_TRUE(refused([](RigCalibration& r) { r.left.coefficients = {1, 2}; }));
  EXPECT_TRUE(refused([](RigCalibration& r) {
    r.left.coefficients = {-3, 0.5, 0, 0};
  })) << "a lens that folds the image";
  EXPECT_TRUE(refused([](RigCalibration& r) {
    r.T_right_left.linear() = rotation_from_rpy(0, 1.5, 0);
    r.T_right_left.translation() = Eigen::Vector3d(-0.2, 0, 0);
  }));
}

TEST(Rectifier, RefusesBadImages) {
  const auto rectifier = Rectifier::create(euroc_rig());
  ASSERT_TRUE(rectifier);
  const cv::Mat good = cv::Mat::zeros(480, 752, CV_8UC1);
  EXPECT_TRUE(rectifier->rectify(good, good));
  EXPECT_FALSE(rectifier->rectify(cv::Mat(), good));
  EXPECT_FALSE(rectifier->rectify(good, cv::Mat::zeros(480, 640, CV_8UC1)));
  EXPECT_FALSE(rectifier->rectify(cv::Mat::zeros(480, 752, CV_8UC3), good));
}

double quantile(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

TEST(Rectifier, RowsOfARealRigAgree) {
  const auto data = testing::data_folder();
  if (!data) GTEST_SKIP() << "the real recordings are not here; set CAIRN_DATA";
  const auto folder = *data / "sequence" / "euroc_v101_static";
  const auto rectifier = Rectifier::create(euroc_rig());
  ASSERT_TRUE(rectifier) << rectifier.error().message;
  std::vector<double> rows_px;
  for (const auto& file : std::filesystem::directory_iterator(folder / "cam0")) {
    const auto name = file.path().filename();
    const auto pair =
        rectifier->rectify(cv::imread((folder / "cam0" / name).string(), cv::IMREAD_GRAYSCALE),
                           cv::imread((folder / "cam1" / name).string(), cv::IMREAD_GRAYSCALE));
    ASSERT_TRUE(pair) << pair.error().message;
    std::vector<cv::Point2f> corners;
    std::vector<cv::Point2f> there;
    std::vector<cv::Point2f> back;
    std::vector<std::uint8_t> went;
    std::vector<std::uint8_t> returned;
    cv::goodFeaturesToTrack(pair->left, corners, 300, 0.01, 12);
    cv::calcOpticalFlowPyrLK(pair->left, pair->right, corners, there, went, cv::noArray(), {21, 21},
                             4);
    cv::calcOpticalFlowPyrLK(pair->right, pair->left, there, back, returned, cv::noArray(),
                             {21, 21}, 4);
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const auto round_trip = corners[i] - back[i];
      if (went[i] == 0 || returned[i] == 0 || round_trip.dot(round_trip) > 0.04F) continue;
      if (corners[i].x < there[i].x) continue;
      rows_px.push_back(std::abs(static_cast<double>(corners[i].y - there[i].y)));
    }
  }
  ASSERT_GT(rows_px.size(), 500U);
  std::printf("row error of %zu corner matches: median %.3f px, 95 %% %.3f px\n", rows_px.size(),
              quantile(rows_px, 0.5), quantile(rows_px, 0.95));
  EXPECT_LT(quantile(rows_px, 0.5), 0.5);
}

}  // namespace
}  // namespace cairn::stereo
