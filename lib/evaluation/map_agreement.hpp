// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <span>

#include "core/geometry.hpp"

namespace cairn::evaluation {

/// How far two maps of one place say the same of where surfaces are. Shares are fractions of 1;
/// nothing where there was nothing to count.
struct MapAgreement {
  std::size_t points = 0;
  std::size_t reference_points = 0;
  double tolerance_m = 0;
  std::optional<double> precision;  ///< of the points: a reference point lies within tolerance
  std::optional<double> recall;     ///< of the reference points: a point lies within tolerance
  std::optional<double> f_score;    ///< 2 P R / (P + R) (Knapitsch et al. 2017, eq. 5)
};

/// Compares points on surfaces (centres of occupied voxels) with those of a reference, both in the
/// reference's frame.
[[nodiscard]] MapAgreement map_agreement(std::span<const Eigen::Vector3d> points_m,
                                         std::span<const Eigen::Vector3d> reference_m,
                                         double tolerance_m);

}  // namespace cairn::evaluation
