// SPDX-License-Identifier: Apache-2.0
#include "planning/near_sight.hpp"

#include <cmath>

namespace cairn::planning {
namespace {

constexpr double kDeep_m = 0.2;
constexpr double kImageMargin_px = 8;
constexpr double kMadeUp = 2;  // an answer so many times as far as the floor is none
constexpr int kLeastExpected = 6;
constexpr double kMost = 0.4;  // of what would be answered; made-up answers are fewer

int bearing_of(const Eigen::Vector3d& way) {
  return static_cast<int>(std::floor(std::atan2(way.y(), way.x()) / NearSight::kBearing_rad)) +
         NearSight::kBearings / 2;
}

bool is_bearing(int bearing) { return bearing >= 0 && bearing < NearSight::kBearings; }

}  // namespace

void NearSight::look(const stereo::DisparityImage& image, double view_from_m) {
  const stereo::RectifiedCamera& camera = image.camera;
  const Isometry& T = camera.T_body_camera;
  const Eigen::Vector3d left_eye = T.translation();
  const Eigen::Vector3d right_eye = T * Eigen::Vector3d(camera.baseline_m, 0, 0);
  const double fb_px_m = camera.f_px * camera.baseline_m;
  ByBearing<int> expected{};
  ByBearing<int> answers{};
  const auto count = [](std::array<int, kBearings>& counts, const Eigen::Vector3d& way) {
    const int bearing = bearing_of(way);
    if (is_bearing(bearing)) ++counts[static_cast<std::size_t>(bearing)];
  };
  for (int row = 0; row < image.rows(); ++row) {
    for (int col = 0; col < image.cols(); ++col) {
      const double u_px = col * image.step_px;
      const Eigen::Vector3d ray((u_px - camera.cx_px) / camera.f_px,
                                (row * image.step_px - camera.cy_px) / camera.f_px, 1);
      const Eigen::Vector3d way = T.linear() * ray;
      if (!(way.z() < 0)) continue;
      const double depth_m = -left_eye.z() / way.z();
      const Eigen::Vector3d floor = left_eye + depth_m * way;
      if (floor.x() < view_from_m || floor.x() > view_from_m + kDeep_m) continue;
      if (u_px - (fb_px_m / depth_m - camera.doffs_px) < kImageMargin_px) continue;
      count(expected[0], way);
      count(expected[1], floor - right_eye);
      if (!image.valid(row, col) || image.depth_m(row, col) > kMadeUp * depth_m) continue;
      count(answers[0], way);
      count(answers[1], left_eye + image.depth_m(row, col) * way - right_eye);
    }
  }
  for (std::size_t eye = 0; eye < 2; ++eye) {
    for (std::size_t b = 0; b < kBearings; ++b) {
      in_view_[eye][b] = expected[eye][b] >= kLeastExpected;
      if (in_view_[eye][b] && answers[eye][b] >= kMost * expected[eye][b])
        answered_[eye][b] = image.utime;
    }
  }
}

}  // namespace cairn::planning
