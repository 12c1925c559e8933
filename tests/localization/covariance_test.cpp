// SPDX-License-Identifier: Apache-2.0
#include "localization/covariance.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <random>

namespace cairn::localization {
namespace {

Matrix6d random_matrix(std::mt19937& random) {
  std::normal_distribution<double> normal;
  return Matrix6d::NullaryExpr([&] { return normal(random); });
}

TEST(NearestCovariance, LeavesACovarianceAsItIs) {
  std::mt19937 random(1);
  for (int i = 0; i < 20; ++i) {
    const Matrix6d root = random_matrix(random);
    const Matrix6d covariance = root * root.transpose();
    EXPECT_TRUE(nearest_covariance(covariance, 1e-12).isApprox(covariance, 1e-9));
  }
}

// Higham 1988: the distance left is that of the negative eigenvalues, and no covariance is nearer.
TEST(NearestCovariance, IsACovarianceAndNoneIsNearer) {
  std::mt19937 random(2);
  const Vector6d by = levers();
  const auto lever = by.asDiagonal();
  for (int i = 0; i < 20; ++i) {
    const Matrix6d root = random_matrix(random);
    const Matrix6d estimate = root + root.transpose();
    const Matrix6d nearest = nearest_covariance(estimate, 0);
    EXPECT_GE(Eigen::SelfAdjointEigenSolver<Matrix6d>(nearest).eigenvalues().minCoeff(), -1e-9);
    const double off = (lever * (nearest - estimate) * lever).norm();
    for (int k = 0; k < 200; ++k) {
      const Matrix6d aside = 0.1 * random_matrix(random);
      const Matrix6d moved = Matrix6d::Identity() + aside;
      const Matrix6d other = moved * nearest * moved.transpose();
      EXPECT_GE((lever * (other - estimate) * lever).norm(), off - 1e-9);
    }
  }
}

TEST(NearestCovariance, HasNoLessVarianceThanAsked) {
  Matrix6d estimate = Matrix6d::Identity();
  estimate(2, 2) = -1;
  const Matrix6d nearest = nearest_covariance(estimate, 1e-4);
  EXPECT_NEAR(nearest(2, 2), 1e-4, 1e-12);
  EXPECT_NEAR(nearest(0, 0), 1, 1e-12);
}

}  // namespace
}  // namespace cairn::localization
