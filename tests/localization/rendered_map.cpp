// SPDX-License-Identifier: Apache-2.0
#include "rendered_map.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>

#include "mapping/map_delta.hpp"

namespace cairn::testing {
namespace {

constexpr int kStep_px = 2;
constexpr double kMaxDisparity_px = 191;
constexpr double kEdge_px = 3;

}  // namespace

simulation::World world_named(const std::string& name) {
  return simulation::load_world(std::filesystem::path(CAIRN_SOURCE_DIR) / "config" / "worlds" /
                                (name + ".yaml"))
      .value();
}

Isometry on_floor(double x_m, double y_m, double yaw_rad) {
  Isometry T = Isometry::Identity();
  T.linear() = rotation_from_rpy(0, 0, yaw_rad);
  T.translation() = Eigen::Vector3d(x_m, y_m, 0);
  return T;
}

NoisyEyes::NoisyEyes(const simulation::World& world, double noise_px, unsigned seed)
    : noise_px_{noise_px}, random_{seed} {
  Isometry T_body_left = Isometry::Identity();
  T_body_left.linear() = R_body_camera_forward();
  T_body_left.translation() = Eigen::Vector3d(0, 0.127, 0.30);
  const double f_px = 320 / std::tan(std::numbers::pi / 6);
  const auto rig = camera::rectified_rig(f_px, f_px, 319.5, 239.5, 0.254, 640, 480, T_body_left);
  camera_.f_px = f_px;
  camera_.cx_px = 319.5;
  camera_.cy_px = 239.5;
  camera_.baseline_m = 0.254;
  camera_.width_px = 640;
  camera_.height_px = 480;
  camera_.T_body_camera = T_body_left;
  depth_ = std::make_unique<simulation::DepthRenderer>(
      std::move(simulation::DepthRenderer::create(world, rig).value()));
}

stereo::DisparityImage NoisyEyes::look(const Isometry& T_world_body, Utime utime) {
  const cv::Mat_<float> depth_m = depth_->left_m(T_world_body, kStep_px);
  stereo::DisparityImage image;
  image.utime = utime;
  image.step_px = kStep_px;
  image.camera = camera_;
  image.disparity_16ths = cv::Mat_<std::uint16_t>(depth_m.rows, depth_m.cols, std::uint16_t{0});
  image.code = cv::Mat_<std::uint8_t>(depth_m.rows, depth_m.cols, std::uint8_t{0});
  const double fb = camera_.f_px * camera_.baseline_m;
  const auto true_px = [&](int row, int col) {
    return fb / static_cast<double>(depth_m(row, col));
  };
  std::normal_distribution<double> noise(0, 1);
  std::bernoulli_distribution dropped(noise_px_ > 0 ? 0.1 : 0);
  for (int row = 0; row < depth_m.rows; ++row) {
    for (int col = 0; col < depth_m.cols; ++col) {
      const double error_px = noise_px_ * noise(random_);
      const bool drop = dropped(random_);
      const double d = true_px(row, col);
      if (drop || !(d <= kMaxDisparity_px) || d > col * kStep_px) continue;
      const bool edge =
          (col + 1 < depth_m.cols && std::abs(true_px(row, col + 1) - d) > kEdge_px) ||
          (col > 0 && std::abs(true_px(row, col - 1) - d) > kEdge_px);
      if (edge && noise_px_ > 0) continue;
      image.disparity_16ths(row, col) =
          static_cast<std::uint16_t>(std::lround(16 * std::max(0.1, d + error_px)));
      image.code(row, col) = 3;
    }
  }
  return image;
}

void OwnMap::see(const stereo::DisparityImage& image, const Isometry& T_map_body) {
  const auto done = integrator_.integrate(image, T_map_body * image.camera.T_body_camera, map_);
  changed_.insert(changed_.end(), done->changed.begin(), done->changed.end());
}

mapping::MapDelta OwnMap::delta(Utime utime) {
  std::sort(changed_.begin(), changed_.end());
  changed_.erase(std::unique(changed_.begin(), changed_.end()), changed_.end());
  auto delta = mapping::make_delta(map_, 1, utime, changed_);
  changed_.clear();
  return delta;
}

}  // namespace cairn::testing
