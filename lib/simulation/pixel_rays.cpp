// SPDX-License-Identifier: Apache-2.0
#include "simulation/pixel_rays.hpp"

#include <cmath>
#include <opencv2/calib3d.hpp>

namespace cairn::simulation {
namespace {

constexpr double kMaxReprojection_px = 0.05;
constexpr int kIterations = 100;
constexpr double kAccuracy_px = 1e-9;

std::vector<cv::Point2d> undistorted(const camera::CameraModel& camera,
                                     const std::vector<cv::Point2d>& pixels) {
  std::vector<cv::Point2d> rays;
  if (camera.distortion == camera::Distortion::kEquidistant) {
    cv::fisheye::undistortPoints(pixels, rays, camera.K(), camera.coefficients);
  } else {
    const cv::TermCriteria until(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, kIterations,
                                 kAccuracy_px);
    cv::undistortPoints(pixels, rays, camera.K(), camera.coefficients, cv::noArray(), cv::noArray(),
                        until);
  }
  return rays;
}

std::vector<cv::Point2d> projected(const camera::CameraModel& camera,
                                   const std::vector<cv::Point2d>& rays) {
  std::vector<cv::Point2d> pixels;
  if (camera.distortion == camera::Distortion::kEquidistant) {
    cv::fisheye::distortPoints(rays, pixels, camera.K(), camera.coefficients);
  } else {
    std::vector<cv::Point3d> points;
    for (const cv::Point2d& ray : rays) points.emplace_back(ray.x, ray.y, 1.0);
    cv::projectPoints(points, cv::Vec3d(), cv::Vec3d(), camera.K(), camera.coefficients, pixels);
  }
  return pixels;
}

std::vector<cv::Point2d> pinhole_rays(const camera::CameraModel& camera,
                                      const std::vector<cv::Point2d>& pixels) {
  std::vector<cv::Point2d> rays;
  rays.reserve(pixels.size());
  for (const cv::Point2d& pixel : pixels) {
    rays.emplace_back((pixel.x - camera.cx_px) / camera.fx_px,
                      (pixel.y - camera.cy_px) / camera.fy_px);
  }
  return rays;
}

}  // namespace

Result<std::vector<Eigen::Vector3f>> pixel_rays(const camera::CameraModel& camera, int width_px,
                                                int height_px) {
  std::vector<cv::Point2d> pixels;
  for (int row = 0; row < height_px; ++row) {
    for (int col = 0; col < width_px; ++col) pixels.emplace_back(col, row);
  }
  std::vector<cv::Point2d> rays;
  if (camera.distortion == camera::Distortion::kNone) {
    rays = pinhole_rays(camera, pixels);
  } else {
    try {
      rays = undistorted(camera, pixels);
      const std::vector<cv::Point2d> back = projected(camera, rays);
      for (std::size_t i = 0; i < pixels.size(); ++i) {
        if (!(std::hypot(back[i].x - pixels[i].x, back[i].y - pixels[i].y) < kMaxReprojection_px)) {
          return fail("camera: the distortion cannot be inverted at pixel " +
                      std::to_string(static_cast<int>(pixels[i].x)) + ", " +
                      std::to_string(static_cast<int>(pixels[i].y)));
        }
      }
    } catch (const cv::Exception& problem) {
      return fail("camera: the distortion cannot be inverted: " + problem.err);
    }
  }
  std::vector<Eigen::Vector3f> directions;
  directions.reserve(rays.size());
  for (const cv::Point2d& ray : rays) {
    directions.emplace_back(static_cast<float>(ray.x), static_cast<float>(ray.y), 1.0F);
  }
  return directions;
}

std::optional<Eigen::Vector2d> project(const camera::CameraModel& camera,
                                       const Eigen::Vector3d& point_m) {
  if (!(point_m.z() > 0)) return std::nullopt;
  const cv::Point2d ray(point_m.x() / point_m.z(), point_m.y() / point_m.z());
  if (camera.distortion == camera::Distortion::kNone) {
    return Eigen::Vector2d(camera.cx_px + camera.fx_px * ray.x,
                           camera.cy_px + camera.fy_px * ray.y);
  }
  const cv::Point2d pixel = projected(camera, {ray}).front();
  return Eigen::Vector2d(pixel.x, pixel.y);
}

}  // namespace cairn::simulation
