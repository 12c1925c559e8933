// SPDX-License-Identifier: Apache-2.0
#include "evaluation/map_agreement.hpp"

#include <algorithm>

#include "evaluation/map_score.hpp"

namespace cairn::evaluation {
namespace {

// Share of the points that lie within tolerance of one of the others.
std::optional<double> share_near(std::span<const Eigen::Vector3d> points_m,
                                 std::span<const Eigen::Vector3d> others_m, double tolerance_m) {
  if (points_m.empty()) return std::nullopt;
  // Distances beyond the limit come back as the limit; so it lies beyond the tolerance.
  const auto distance_m = distance_to_samples(others_m, 2 * tolerance_m);
  const auto near = std::count_if(
      points_m.begin(), points_m.end(),
      [&](const Eigen::Vector3d& point_m) { return distance_m(point_m) <= tolerance_m; });
  return static_cast<double>(near) / static_cast<double>(points_m.size());
}

}  // namespace

MapAgreement map_agreement(std::span<const Eigen::Vector3d> points_m,
                           std::span<const Eigen::Vector3d> reference_m, double tolerance_m) {
  MapAgreement agreement;
  agreement.points = points_m.size();
  agreement.reference_points = reference_m.size();
  agreement.tolerance_m = tolerance_m;
  agreement.precision = share_near(points_m, reference_m, tolerance_m);
  agreement.recall = share_near(reference_m, points_m, tolerance_m);
  if (agreement.precision && agreement.recall) {
    const double sum = *agreement.precision + *agreement.recall;
    agreement.f_score = sum > 0 ? 2 * *agreement.precision * *agreement.recall / sum : 0;
  }
  return agreement;
}

}  // namespace cairn::evaluation
