// SPDX-License-Identifier: Apache-2.0
#include "bench_eyes.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace cairn::testing {
namespace {

constexpr double kBaseline_m = 0.254;
constexpr double kFarthest_m = 12;

}  // namespace

camera::RigCalibration bench_rig() {
  Isometry T_body_left = Isometry::Identity();
  T_body_left.linear() = R_body_camera_forward();
  T_body_left.translation() = Eigen::Vector3d(0, kBaseline_m / 2, 0.30);
  const double f_px = 320 / std::tan(std::numbers::pi / 6);
  return camera::rectified_rig(f_px, f_px, 319.5, 239.5, kBaseline_m, 640, 480, T_body_left);
}

BenchEyes::BenchEyes(const simulation::World& world, int step_px, const EyeTrouble& trouble,
                     unsigned seed)
    : rig_{bench_rig()}, step_px_{step_px}, trouble_{trouble}, random_{seed} {
  see(world);
}

void BenchEyes::see(const simulation::World& world) {
  renderer_ = std::make_unique<simulation::DepthRenderer>(
      std::move(simulation::DepthRenderer::create(world, rig_).value()));
}

stereo::DisparityImage BenchEyes::look(const Isometry& T_world_body, Utime utime,
                                       std::span<const simulation::PersonPose> people) {
  const cv::Mat_<float> depth_m = renderer_->left_m(T_world_body, step_px_, people);
  stereo::DisparityImage image;
  image.utime = utime;
  image.step_px = step_px_;
  image.camera = {rig_.left.fx_px, rig_.left.cx_px, rig_.left.cy_px, 0,
                  kBaseline_m,     rig_.width_px,   rig_.height_px,  rig_.T_body_left};
  image.disparity_16ths = cv::Mat_<std::uint16_t>::zeros(depth_m.size());
  image.code = cv::Mat_<std::uint8_t>(depth_m.size(),
                                      static_cast<std::uint8_t>(stereo::Reason::kNoData));
  const double fb = image.camera.f_px * kBaseline_m;
  std::normal_distribution<double> noise_px(0, trouble_.noise_px);
  std::uniform_real_distribution<double> chance(0, 1);
  for (int row = 0; row < depth_m.rows; ++row) {
    for (int col = 0; col < depth_m.cols; ++col) {
      const double luck = chance(random_);
      const double error_px = noise_px(random_);
      if (luck < trouble_.drop_out) continue;
      int from = col;
      if (luck > 1 - trouble_.bleed) from += luck > 1 - trouble_.bleed / 2 ? 1 : -1;
      const double z_m =
          static_cast<double>(depth_m(row, std::clamp(from, 0, depth_m.cols - 1)));
      if (!(z_m >= trouble_.nearest_m) || z_m > kFarthest_m) continue;
      const double disparity_px = fb / z_m + error_px;
      if (fb / z_m > col * step_px_ || disparity_px < 0.5) continue;
      image.disparity_16ths(row, col) = static_cast<std::uint16_t>(std::lround(16 * disparity_px));
      image.code(row, col) = 3;
    }
  }
  return image;
}

}  // namespace cairn::testing
