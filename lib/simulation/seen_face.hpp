// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "core/geometry.hpp"
#include "simulation/face.hpp"

namespace cairn::simulation {

/// A face as one eye at one place sees it. Along the ray (x, y, 1) in the eye's axes the inverse of
/// the depth is linear in x and y: inverse_depth . (x, y, 1); the point there lies at (s, t) =
/// start + depth * (axis . (x, y, 1)) on the face.
struct SeenFace {
  Eigen::Vector3f inverse_depth;  ///< [1/m]
  Eigen::Vector3f normal;
  Eigen::Vector3f axis_s;
  Eigen::Vector3f axis_t;
  float start_s_m;
  float start_t_m;

  [[nodiscard]] float inverse_depth_at(float x, float y) const {
    return inverse_depth.x() * x + inverse_depth.y() * y + inverse_depth.z();
  }
};

/// Appends them in the faces' order.
inline void see_faces(std::span<const Face> faces, const Isometry& T_world_eye,
                      std::vector<SeenFace>& seen) {
  const Eigen::Matrix3d R_eye_world = T_world_eye.linear().transpose();
  for (const Face& face : faces) {
    const Eigen::Vector3d to_corner = face.corner_m - T_world_eye.translation();
    const Eigen::Vector3d normal = R_eye_world * face.normal;
    seen.push_back({(normal / face.normal.dot(to_corner)).cast<float>(), normal.cast<float>(),
                    (R_eye_world * face.axis_s).cast<float>(),
                    (R_eye_world * face.axis_t).cast<float>(),
                    static_cast<float>(-face.axis_s.dot(to_corner)),
                    static_cast<float>(-face.axis_t.dot(to_corner))});
  }
}

}  // namespace cairn::simulation
