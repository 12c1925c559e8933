// SPDX-License-Identifier: Apache-2.0
#include "odometry/rendered_room.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

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

/// A paper's grey value at `x`, `y` in texels.
double grey_on(const cv::Mat_<float>& paper, double x, double y) {
  const int i = std::clamp(static_cast<int>(x), 0, paper.cols - 2);
  const int j = std::clamp(static_cast<int>(y), 0, paper.rows - 2);
  const auto grey = [&](int row, int col) { return static_cast<double>(paper(row, col)); };
  return std::lerp(std::lerp(grey(j, i), grey(j, i + 1), x - i),
                   std::lerp(grey(j + 1, i), grey(j + 1, i + 1), x - i), y - j);
}

/// Where a ray meets the panel's plane, in the panel's frame; nothing if that is not on the panel,
/// or behind.
std::optional<Eigen::Vector3d> on_panel(const Panel& panel, const Eigen::Vector3d& from_m,
                                        const Eigen::Vector3d& direction) {
  const Isometry T_panel_room = panel.T_room_panel.inverse();
  const Eigen::Vector3d from = T_panel_room * from_m;
  const Eigen::Vector3d along = T_panel_room.linear() * direction;
  const double way = -from.x() / along.x();
  if (!(way > 0) || !std::isfinite(way)) return std::nullopt;
  const Eigen::Vector3d at = from + way * along;
  if (std::abs(at.y()) > panel.width_m / 2 || std::abs(at.z()) > panel.height_m / 2)
    return std::nullopt;
  return at;
}

/// The grey value where the ray first meets the panel, or the room's wall, floor or ceiling.
double grey_along(const Eigen::Vector3d& from_m, const Eigen::Vector3d& direction,
                  const Panel* panel) {
  if (panel != nullptr) {
    if (const auto at = on_panel(*panel, from_m, direction))
      return grey_on(paper_of(0), (at->y() + panel->width_m / 2) / kTexel_m,
                     (at->z() + panel->height_m / 2) / kTexel_m);
  }
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
  return grey_on(paper_of(face), at[(face / 2 + 1) % 3], at[(face / 2 + 2) % 3]);
}

cv::Mat render(const stereo::RectifiedCamera& camera, double cx_px, const Isometry& T_room_camera,
               const Panel* panel) {
  cv::Mat_<std::uint8_t> image(camera.height_px, camera.width_px);
  const Eigen::Vector3d from_m = T_room_camera.translation();
  for (int v = 0; v < image.rows; ++v) {
    for (int u = 0; u < image.cols; ++u) {
      double sum = 0;
      for (const double dv : {-0.25, 0.25}) {
        for (const double du : {-0.25, 0.25}) {
          const Eigen::Vector3d ray{(u + du - cx_px) / camera.f_px,
                                    (v + dv - camera.cy_px) / camera.f_px, 1};
          sum += grey_along(from_m, T_room_camera.linear() * ray, panel);
        }
      }
      image(v, u) = static_cast<std::uint8_t>(std::lround(sum / 4));
    }
  }
  return image;
}

}  // namespace

cv::Mat RenderedRoom::left(const stereo::RectifiedCamera& camera, const Isometry& T_room_body,
                           const Panel* panel) {
  return render(camera, camera.cx_px, T_room_body * camera.T_body_camera, panel);
}

cv::Mat RenderedRoom::right(const stereo::RectifiedCamera& camera, const Isometry& T_room_body,
                            const Panel* panel) {
  return render(camera, camera.cx_px + camera.doffs_px,
                T_room_body * camera.T_body_camera * Eigen::Translation3d(camera.baseline_m, 0, 0),
                panel);
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
