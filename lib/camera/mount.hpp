// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "core/config.hpp"
#include "core/geometry.hpp"

namespace cairn::camera {

/// Where the left camera sits on the body, as a person measures it: at rpy 0 it looks straight
/// ahead.
struct MountConfig {
  std::vector<double> xyz_m;
  std::vector<double> rpy_deg;

  void visit(ConfigVisitor& v) {
    v.numbers("xyz_m", xyz_m, 3, 3, {-100, 100}, "m", "left camera on the body: ahead, left, up");
    v.numbers("rpy_deg", rpy_deg, 3, 3, {-360, 360}, "deg",
              "roll, pitch (positive looks down), yaw; 0 looks straight ahead");
  }
};

/// T_body_left of a mount; a list that is not given counts as zero.
[[nodiscard]] inline Isometry mounted(const MountConfig& mount) {
  constexpr double kRadPerDeg = 3.14159265358979323846 / 180;
  Isometry T_body_left = Isometry::Identity();
  T_body_left.linear() = R_body_camera_forward();
  if (mount.xyz_m.size() == 3) {
    T_body_left.translation() = Eigen::Map<const Eigen::Vector3d>(mount.xyz_m.data());
  }
  if (mount.rpy_deg.size() == 3) {
    T_body_left.linear() =
        rotation_from_rpy(mount.rpy_deg[0] * kRadPerDeg, mount.rpy_deg[1] * kRadPerDeg,
                          mount.rpy_deg[2] * kRadPerDeg) *
        R_body_camera_forward();
  }
  return T_body_left;
}

}  // namespace cairn::camera
