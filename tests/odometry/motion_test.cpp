// SPDX-License-Identifier: Apache-2.0
#include "odometry/motion.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace cairn::odometry {
namespace {

TEST(Motion, TwistOfUndoesMotionOf) {
  Twist twist;
  twist << 0.5, -0.1, 0.02, 0.3, -0.4, 1.9;
  for (const double dt_s : {0.01, 0.1, 1.0}) {
    EXPECT_TRUE(twist_of(motion_of(twist, dt_s), dt_s).isApprox(twist, 1e-9)) << dt_s;
  }
}

TEST(Motion, DrivesACircle) {
  Twist twist = Twist::Zero();
  twist[0] = 1;
  twist[5] = 0.5;
  const Isometry T = motion_of(twist, 0.2);
  const double radius_m = 2;
  EXPECT_NEAR(yaw_rad(T), 0.1, 1e-12);
  EXPECT_NEAR(T.translation().x(), radius_m * std::sin(0.1), 1e-4);
  EXPECT_NEAR(T.translation().y(), radius_m * (1 - std::cos(0.1)), 1e-4);
}

TEST(Motion, CovarianceChangesFramesAsSamplesDo) {
  Isometry T_a_b = Isometry::Identity();
  T_a_b.linear() = rotation_from_rpy(0.4, -0.7, 1.1);
  T_a_b.translation() = Eigen::Vector3d(0.3, -0.5, 0.8);
  Vector6d sigma;
  sigma << 1e-3, 2e-3, 5e-4, 4e-3, 1e-3, 2e-3;
  const Matrix6d covariance_b = sigma.cwiseAbs2().asDiagonal();
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  Matrix6d sampled = Matrix6d::Zero();
  constexpr int kSamples = 20000;
  for (int i = 0; i < kSamples; ++i) {
    Vector6d small;
    for (int k = 0; k < 6; ++k) small[k] = sigma[k] * normal(random);
    Isometry motion_b = Isometry::Identity();
    motion_b.linear() = exp_so3(small.tail<3>());
    motion_b.translation() = small.head<3>();
    const Isometry motion_a = T_a_b * motion_b * T_a_b.inverse();
    Vector6d in_a;
    in_a << motion_a.translation(), log_so3(motion_a.linear());
    sampled += in_a * in_a.transpose() / kSamples;
  }
  const Matrix6d predicted = covariance_in(T_a_b, covariance_b);
  EXPECT_LT((sampled - predicted).norm(), 0.03 * predicted.norm());
}

}  // namespace
}  // namespace cairn::odometry
