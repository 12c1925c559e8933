// SPDX-License-Identifier: Apache-2.0
#include "simulation/eye.hpp"

#include "simulation/pixel_rays.hpp"

namespace cairn::simulation {

Result<Eye> make_eye(const camera::CameraModel& camera, int width_px, int height_px,
                     const Isometry& T_body_eye) {
  const auto rays = pixel_rays(camera, width_px, height_px);
  if (!rays) return tl::make_unexpected(rays.error());
  Eye eye;
  eye.width_px = width_px;
  eye.height_px = height_px;
  eye.T_body_eye = T_body_eye;
  eye.pixel_angle_x = static_cast<float>(1 / camera.fx_px);
  eye.pixel_angle_y = static_cast<float>(1 / camera.fy_px);
  eye.ray_x.reserve(rays->size());
  eye.ray_y.reserve(rays->size());
  for (const Eigen::Vector3f& ray : *rays) {
    eye.ray_x.push_back(ray.x());
    eye.ray_y.push_back(ray.y());
  }
  return eye;
}

}  // namespace cairn::simulation
