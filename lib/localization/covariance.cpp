// SPDX-License-Identifier: Apache-2.0
#include "localization/covariance.hpp"

#include <Eigen/Eigenvalues>

namespace cairn::localization {

Vector6d levers() {
  Vector6d lever;
  lever << 1, 1, 1, kLever_m, kLever_m, kLever_m;
  return lever;
}

Matrix6d nearest_covariance(const Matrix6d& estimate, double least_m2) {
  const Vector6d lever = levers();
  const Matrix6d symmetric = 0.5 * (estimate + estimate.transpose());
  const Eigen::SelfAdjointEigenSolver<Matrix6d> solver(lever.asDiagonal() * symmetric *
                                                       lever.asDiagonal());
  const Matrix6d levered = solver.eigenvectors() *
                           solver.eigenvalues().cwiseMax(least_m2).asDiagonal() *
                           solver.eigenvectors().transpose();
  return lever.cwiseInverse().asDiagonal() * levered * lever.cwiseInverse().asDiagonal();
}

}  // namespace cairn::localization
