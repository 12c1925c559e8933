// SPDX-License-Identifier: Apache-2.0
#include "odometry/rendered_room.hpp"

#include <cmath>
#include <limits>

#include "stereo/texture.hpp"

namespace cairn::testing {
namespace {

const Eigen::Vector3d kLow_m{-3, -2.5, 0};
const Eigen::Vector3d kHigh_m{3, 2.5, 2.5};
constexpr double kFeature_m = 0.03;

/// The grey value where the ray first meets the room's wall, floor or ceiling.
double grey_along(const Eigen::Vector3d& from_m, const Eigen::Vector3d& direction) {
  double nearest = std::numeric_limits<double>::infinity();
  int face = 0;
  for (int axis = 0; axis < 3; ++axis) {
    if (direction[axis] == 0) continue;
    const bool high = direction[axis] > 0;
    const double way = ((high ? kHigh_m : kLow_m)[axis] - from_m[axis]) / direction[axis];
    if (way > 0 && way < nearest) {
      nearest = way;
      face = 2 * axis + (high ? 1 : 0);
    }
  }
  const Eigen::Vector3d at_m = from_m + nearest * direction;
  const int axis = face / 2;
  return surface_grey(at_m[(axis + 1) % 3], at_m[(axis + 2) % 3], kFeature_m,
                      100 + static_cast<std::uint64_t>(10 * face));
}

cv::Mat render(const stereo::RectifiedCamera& camera, double cx_px, const Isometry& T_room_camera) {
  cv::Mat_<std::uint8_t> image(camera.height_px, camera.width_px);
  const Eigen::Vector3d from_m = T_room_camera.translation();
  for (int v = 0; v < image.rows; ++v) {
    for (int u = 0; u < image.cols; ++u) {
      double sum = 0;
      for (const double dv : {-0.25, 0.25}) {
        for (const double du : {-0.25, 0.25}) {
          const Eigen::Vector3d ray{(u + du - cx_px) / camera.f_px,
                                    (v + dv - camera.cy_px) / camera.f_px, 1};
          sum += grey_along(from_m, T_room_camera.linear() * ray);
        }
      }
      image(v, u) = static_cast<std::uint8_t>(std::lround(sum / 4));
    }
  }
  return image;
}

}  // namespace

cv::Mat RenderedRoom::left(const stereo::RectifiedCamera& camera, const Isometry& T_room_body) {
  return render(camera, camera.cx_px, T_room_body * camera.T_body_camera);
}

cv::Mat RenderedRoom::right(const stereo::RectifiedCamera& camera, const Isometry& T_room_body) {
  return render(camera, camera.cx_px + camera.doffs_px,
                T_room_body * camera.T_body_camera * Eigen::Translation3d(camera.baseline_m, 0, 0));
}

stereo::RectifiedCamera robot_camera() {
  stereo::RectifiedCamera camera;
  camera.f_px = 554;
  camera.cx_px = 319.5;
  camera.cy_px = 239.5;
  camera.baseline_m = 0.254;
  camera.width_px = 640;
  camera.height_px = 480;
  camera.T_body_camera.linear() =
      rotation_from_rpy(0, 5 * 3.14159265358979 / 180, 0) * R_body_camera_forward();
  camera.T_body_camera.translation() = Eigen::Vector3d(0.15, 0.127, 0.3);
  return camera;
}

cv::Mat with_noise(const cv::Mat& image, double sigma, std::uint64_t seed) {
  cv::RNG random(seed);
  cv::Mat noise(image.size(), CV_16SC1);
  random.fill(noise, cv::RNG::NORMAL, 0, sigma);
  cv::Mat sum;
  cv::add(image, noise, sum, cv::noArray(), CV_8U);
  return sum;
}

}  // namespace cairn::testing
