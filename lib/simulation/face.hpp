// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

#include "simulation/world.hpp"

namespace cairn::simulation {

/// One side of a box: the rectangle corner + s * axis_s + t * axis_t, 0 <= s <= size_s, 0 <= t <=
/// size_t.
struct Face {
  Eigen::Vector3d corner_m;
  Eigen::Vector3d axis_s;  ///< unit length
  Eigen::Vector3d axis_t;  ///< unit length
  Eigen::Vector3d normal;  ///< axis_s x axis_t, out of the box
  double size_s_m;
  double size_t_m;

  [[nodiscard]] Eigen::Vector3d at(double s_m, double t_m) const {
    return corner_m + s_m * axis_s + t_m * axis_t;
  }
};

inline constexpr std::size_t kFacesPerBox = 6;

/// In the world frame: +x, -x, +y, -y, +z, -z of the box.
[[nodiscard]] inline std::array<Face, kFacesPerBox> faces_of(const Box& box) {
  std::array<Face, kFacesPerBox> faces;
  const Eigen::Matrix3d& R = box.T_world_box.linear();
  for (int side = 0; side < static_cast<int>(kFacesPerBox); ++side) {
    const int n = side / 2;
    const bool positive = side % 2 == 0;
    const int s = (n + (positive ? 1 : 2)) % 3;
    const int t = (n + (positive ? 2 : 1)) % 3;
    Eigen::Vector3d corner_box = -box.half_size_m;
    if (positive) corner_box(n) = box.half_size_m(n);
    faces[static_cast<std::size_t>(side)] = {box.T_world_box * corner_box,
                                             R.col(s),
                                             R.col(t),
                                             (positive ? 1.0 : -1.0) * R.col(n),
                                             2 * box.half_size_m(s),
                                             2 * box.half_size_m(t)};
  }
  return faces;
}

/// A straight edge of a box, in the world frame.
struct Edge {
  Eigen::Vector3d from_m;
  Eigen::Vector3d to_m;
};

inline constexpr std::size_t kEdgesPerBox = 12;

/// In the world frame: four along x, four along y, four along z of the box.
[[nodiscard]] inline std::array<Edge, kEdgesPerBox> edges_of(const Box& box) {
  std::array<Edge, kEdgesPerBox> edges;
  for (int i = 0; i < static_cast<int>(kEdgesPerBox); ++i) {
    const int along = i / 4;
    Eigen::Vector3d from = -box.half_size_m;
    if (i % 2 != 0) from((along + 1) % 3) *= -1;
    if (i / 2 % 2 != 0) from((along + 2) % 3) *= -1;
    Eigen::Vector3d to = from;
    to(along) *= -1;
    edges[static_cast<std::size_t>(i)] = {box.T_world_box * from, box.T_world_box * to};
  }
  return edges;
}

}  // namespace cairn::simulation
