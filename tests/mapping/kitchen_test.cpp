// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <iostream>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <vector>

#include "data_folder.hpp"
#include "mapping/map_file.hpp"
#include "mapping/ray_integrator.hpp"
#include "mapping/raycast.hpp"
#include "mapping/top_down.hpp"
#include "stereo/depth_to_disparity.hpp"

namespace cairn::mapping {
namespace {

/// Real depth images with true poses (7-Scenes); numbers as in the recording's dataset.yaml.
class Kitchen : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto data = cairn::testing::data_folder();
    if (!data) GTEST_SKIP() << "no real recordings here; CAIRN_DATA names their folder";
    folder_ = *data / "sequence" / "kitchen_depth";
    std::ifstream file{folder_ / "poses.txt"};
    Eigen::Matrix<double, 3, 4, Eigen::RowMajor> pose;
    while (true) {
      for (double& value : pose.reshaped<Eigen::RowMajor>()) file >> value;
      if (!file) break;
      Isometry T_map_camera = Isometry::Identity();
      T_map_camera.linear() = R_body_camera_forward() * pose.leftCols<3>();
      T_map_camera.translation() = R_body_camera_forward() * pose.col(3);
      T_map_camera_.push_back(T_map_camera);
    }
    cv::glob((folder_ / "depth" / "*.png").string(), names_);
    ASSERT_EQ(T_map_camera_.size(), names_.size());
    ASSERT_FALSE(names_.empty());
  }

  stereo::DisparityImage image(std::size_t i, int step_px) const {
    const cv::Mat millimetres = cv::imread(names_[i], cv::IMREAD_UNCHANGED);
    cv::Mat depth_m;
    millimetres.convertTo(depth_m, CV_32F, 0.001);
    depth_m.setTo(0, millimetres == 65535);
    stereo::RectifiedCamera camera;
    camera.f_px = 585;
    camera.cx_px = 320;
    camera.cy_px = 240;
    camera.baseline_m = 0.254;
    camera.width_px = 640;
    camera.height_px = 480;
    return stereo::disparity_from_depth(depth_m, camera, step_px, 0).value();
  }

  std::filesystem::path folder_;
  std::vector<Isometry> T_map_camera_;
  std::vector<cv::String> names_;
};

TEST_F(Kitchen, RaysCastFromAPoseThatWasNotMappedMeetTheMapWhereTheCameraSawTheSurface) {
  constexpr double kResolution_m = 0.02;
  RayIntegratorConfig config;
  config.max_range_m = 4;
  RayIntegrator integrator{config};
  VoxelMap map{kResolution_m};
  for (std::size_t i = 0; i < 120; i += 4) {
    ASSERT_TRUE(integrator.integrate(image(i, 2), T_map_camera_[i], map));
  }
  // The map's surface is a shell of noise and whole voxels, and a ray stops at its near side,
  // earlier the more it grazes: so errors are mostly negative. A ray that goes on behind the
  // surface tells of one that was erased or missed.
  std::size_t rays = 0;
  std::size_t behind = 0;
  std::size_t within_two = 0;
  std::size_t within_four = 0;
  for (std::size_t i = 2; i < 120; i += 16) {
    const stereo::DisparityImage seen = image(i, 8);
    for (int row = 0; row < seen.rows(); ++row) {
      for (int col = 0; col < seen.cols(); ++col) {
        if (!seen.valid(row, col)) continue;
        const Eigen::Vector3d point = seen.point_camera(row, col);
        if (point.norm() > config.max_range_m - 0.1) continue;
        const auto hit = raycast(map, T_map_camera_[i].translation(),
                                 T_map_camera_[i].linear() * point, config.max_range_m);
        const double error_m = hit ? hit->distance_m - point.norm() : config.max_range_m;
        ++rays;
        behind += error_m >= 2 * kResolution_m ? 1 : 0;
        within_two += std::abs(error_m) < 2 * kResolution_m ? 1 : 0;
        within_four += std::abs(error_m) < 4 * kResolution_m ? 1 : 0;
      }
    }
  }
  const auto percent = [rays](std::size_t count) {
    return 100.0 * static_cast<double>(count) / static_cast<double>(rays);
  };
  std::cout << rays << " rays: " << percent(within_two)
            << " % within two voxels of the measured range, " << percent(within_four)
            << " % within four, " << percent(behind) << " % behind or nothing\n";
  EXPECT_GT(rays, 30000u);
  EXPECT_GT(percent(within_two), 60);
  EXPECT_GT(percent(within_four), 80);
  EXPECT_LT(percent(behind), 10);
}

TEST_F(Kitchen, MappingItTwiceGivesTheSameBytesAndTheSamePicture) {
  const auto mapped = [&] {
    RayIntegrator integrator{RayIntegratorConfig{}};
    VoxelMap map{0.02};
    for (std::size_t i = 0; i < names_.size(); i += 40) {
      EXPECT_TRUE(integrator.integrate(image(i, 2), T_map_camera_[i], map));
    }
    return map;
  };
  const VoxelMap first = mapped();
  const VoxelMap second = mapped();
  EXPECT_EQ(encode_map(first, {1, 2}), encode_map(second, {1, 2}));
  TopDownOverlay overlay;
  for (const Isometry& T : T_map_camera_) overlay.true_path.push_back(T.translation());
  const cv::Mat picture = render_top_down(first, overlay);
  EXPECT_EQ(cv::norm(picture, render_top_down(second, overlay), cv::NORM_INF), 0);
}

}  // namespace
}  // namespace cairn::mapping
