// SPDX-License-Identifier: Apache-2.0
#include "core/geometry.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace cairn {
namespace {

TEST(Geometry, CameraAxesMapToBodyAxes) {
  const Eigen::Matrix3d R = R_body_camera_forward();
  EXPECT_TRUE((R * Eigen::Vector3d::UnitZ()).isApprox(Eigen::Vector3d::UnitX()));   // ahead
  EXPECT_TRUE((R * Eigen::Vector3d::UnitX()).isApprox(-Eigen::Vector3d::UnitY()));  // right
  EXPECT_TRUE((R * Eigen::Vector3d::UnitY()).isApprox(-Eigen::Vector3d::UnitZ()));  // down
}

TEST(Geometry, RollPitchYawTurnInThatOrder) {
  const Eigen::Matrix3d R = rotation_from_rpy(0, M_PI / 2, M_PI / 2);
  // Pitched up by 90 degrees about y, then turned left: the forward axis ends up pointing down.
  EXPECT_TRUE((R * Eigen::Vector3d::UnitX()).isApprox(-Eigen::Vector3d::UnitZ(), 1e-12));
  EXPECT_TRUE((R * Eigen::Vector3d::UnitZ()).isApprox(Eigen::Vector3d::UnitY(), 1e-12));
}

TEST(Geometry, RotationAngleIsExactNearZeroAndNearPi) {
  for (const double angle : {0.0, 1e-9, 1e-4, 0.5, M_PI - 1e-6, M_PI}) {
    EXPECT_NEAR(rotation_angle_rad(exp_so3({0, 0, angle})), angle, 1e-12 + 1e-9 * angle);
  }
}

TEST(Geometry, LogUndoesExp) {
  const Eigen::Vector3d w{0.3, -1.2, 0.7};
  EXPECT_TRUE(log_so3(exp_so3(w)).isApprox(w, 1e-12));
}

TEST(Geometry, NearestRotationOfAMirrorIsProper) {
  Eigen::Matrix3d M = Eigen::Matrix3d::Identity();
  M(2, 2) = -0.1;
  const Eigen::Matrix3d R = nearest_rotation(M);
  EXPECT_NEAR(R.determinant(), 1.0, 1e-12);
  EXPECT_TRUE((R * R.transpose()).isIdentity(1e-12));
}

}  // namespace
}  // namespace cairn
