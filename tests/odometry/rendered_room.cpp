// SPDX-License-Identifier: Apache-2.0
#include "odometry/rendered_room.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "stereo/texture.hpp"

namespace cairn::testing {
namespace {

const Eigen::Vector3d kLow_m{-3, -2.5, 0};
const Eigen::Vector3d kHigh_m{3, 2.5, 2.5};
constexpr double kFeature_m = 0.03;
constexpr double kTexel_m = 0.005;

/// The paper on one face: grey values at the corners of a 5 mm grid, linear in between.
cv::Mat_<float> make_paper(int face) {
  const int axis = face / 2;
  const Eigen::Vector3d size_m = kHigh_m - kLow_m;
  cv::Mat_<float> paper(static_cast<int>(size_m[(axis + 2) % 3] / kTexel_m) + 2,
                        static_cast<int>(size_m[(axis + 1) % 3] / kTexel_m) + 2);
  const std::uint64_t seed = 100 + 10 * static_cast<std::uint64_t>(face);
  for (int j = 0; j < paper.rows; ++j) {
    for (int i = 0; i < paper.cols; ++i) {
      paper(j, i) = static_cast<float>(surface_grey(i * kTexel_m, j * kTexel_m, kFeature_m, seed));
    }
  }
  return paper;
}

const cv::Mat_<float>& paper_of(int face) {
  static const std::array<cv::Mat_<float>, 6> papers{make_paper(0), make_paper(1), make_paper(2),
                                                     make_paper(3), make_paper(4), make_paper(5)};
  return papers[static_cast<std::size_t>(face)];
}

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
  const Eigen::Vector3d at = (from_m + nearest * direction - kLow_m) / kTexel_m;
  const double x = at[(face / 2 + 1) % 3];
  const double y = at[(face / 2 + 2) % 3];
  const cv::Mat_<float>& paper = paper_of(face);
  const int i = std::clamp(static_cast<int>(x), 0, paper.cols - 2);
  const int j = std::clamp(static_cast<int>(y), 0, paper.rows - 2);
  const auto grey = [&](int row, int col) { return static_cast<double>(paper(row, col)); };
  return std::lerp(std::lerp(grey(j, i), grey(j, i + 1), x - i),
                   std::lerp(grey(j + 1, i), grey(j + 1, i + 1), x - i), y - j);
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
