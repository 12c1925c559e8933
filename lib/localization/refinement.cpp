// SPDX-License-Identifier: Apache-2.0
#include "localization/refinement.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "localization/covariance.hpp"

namespace cairn::localization {
namespace {

/// No view makes a pose surer than this along any direction.
constexpr double kLeastVariance_m2 = 1e-8;
/// Residuals of this many deviations count a quarter in a step (Geman and McClure).
constexpr double kKernel = 2;
/// The kernel's extra width halves from step to step, down to this.
constexpr double kLeastSoftness_m = 0.004;
/// A step that moves less than this ends the search [m, and at kLever_m].
constexpr double kSettled_m = 2e-4;
/// Fit is told at the scale of a cell; a hit lies within this many.
constexpr double kHit_cells = 1.25;
/// What is this much over the floor stands on it.
constexpr double kStanding_m = 0.15;
/// Beams that count less than this are left out.
constexpr double kLeastCounts = 0.02;
constexpr double kBetter = 1e-3;  // of the cost: less is no improvement

/// How far behind a surface the middle of its voxels lies, as one sees it: rays that graze it eat
/// its front. In voxels; what it is in a view is estimated with the pose.
constexpr double kRecession_voxels = 0.3;
constexpr double kRecessionSigma_voxels = 0.2;

using Vector7d = Eigen::Matrix<double, 7, 1>;
using Matrix7d = Eigen::Matrix<double, 7, 7>;

/// How far a patch's normal may point amiss [rad]. What a point seems to say of a direction that
/// its surface does not face more than this is not counted.
constexpr double kRoughness = 0.25;

/// The points' errors are not independent of each other, least of all in the direction that few of
/// them determine: along it they are off by so many of the deviations that independent points would
/// have.
constexpr double kShared = 4;

/// One point's residual: how it changes with translation [m], rotation times kLever_m [m] and
/// recession [m].
struct Residual {
  Vector7d J;
  double arm_m = 0;  ///< from the body's origin
  double off_m = 0;
  double weight = 0;       ///< in this step
  double information = 0;  ///< 1 / m^2, what it would weigh without softness
};

struct Equations {
  std::vector<Residual> residuals;
  double points = 0;
};

/// Where the surface nearest to a point lies, by the field alone; nothing where that is beyond
/// `reach_m`.
std::optional<Eigen::Vector3d> onto_surface(const Eigen::Vector3d& point_m,
                                            const DistanceField& field,
                                            DistanceField::Cursor& cells, double reach_m) {
  const auto distance = [&](CellIndex cell) {
    return static_cast<double>(cells.at(cell) & ~DistanceField::kUnknownBit) /
           DistanceField::kStepsPerCell;
  };
  const CellIndex cell = field.cell_at(point_m);
  const double cells_away = distance(cell);
  if (cells_away * field.cell_m() > reach_m || cells_away >= DistanceField::kReach_cells) {
    return std::nullopt;
  }
  if (cells_away <= 1) return point_m;
  const Eigen::Vector3d uphill(
      distance({cell.x + 1, cell.y, cell.z}) - distance({cell.x - 1, cell.y, cell.z}),
      distance({cell.x, cell.y + 1, cell.z}) - distance({cell.x, cell.y - 1, cell.z}),
      distance({cell.x, cell.y, cell.z + 1}) - distance({cell.x, cell.y, cell.z - 1}));
  const double steepness = uphill.norm() / 2;
  if (steepness < 0.5) return std::nullopt;  // midway between two surfaces
  return field.centre_of(cell) - uphill * (cells_away * field.cell_m() / uphill.norm());
}

Equations equations(const MapView& map, const View& view, const MapAuthority& authority,
                    const Isometry& T, double recession_m, double softness_m, double reach_m) {
  Equations sum;
  sum.residuals.reserve(view.beams.size());
  DistanceField::Cursor cells{map.field};
  for (std::size_t k = 0; k < view.beams.size(); ++k) {
    const Beam& beam = view.beams[k];
    const double counts = authority.shares.empty() ? 1 : authority.shares[k];
    if (counts < kLeastCounts) continue;
    const Eigen::Vector3d arm = T.linear() * beam.point_m;
    const Eigen::Vector3d point = arm + T.translation();
    const auto foot = onto_surface(point, map.field, cells, reach_m);
    if (!foot) continue;
    const SurfacePatch* patch = map.surfaces.near(*foot, map.field, map.map);
    if (patch == nullptr) continue;
    const Eigen::Vector3d along = T.linear() * beam.along;
    bool used = false;
    for (int i = 0; i < patch->directions; ++i) {
      const Eigen::Vector3d& across = patch->across[i];
      const double side = across.dot(along) > 0 ? 1 : -1;
      const double off = across.dot(point - patch->middle_m) + side * recession_m;
      if (std::abs(off) > reach_m) continue;
      const double noise = beam.sigma_m * across.dot(along);
      const double variance = patch->sigma_m[i] * patch->sigma_m[i] + noise * noise;
      const double softened = variance + softness_m * softness_m;
      const double share = 1 / (1 + off * off / (kKernel * kKernel * softened));
      Residual residual;
      residual.J << across, arm.cross(across) / kLever_m, side;
      residual.arm_m = arm.norm();
      residual.off_m = off;
      residual.weight = counts * share * share / softened;
      residual.information = counts * share * share / variance;
      sum.residuals.push_back(residual);
      used = true;
    }
    sum.points += used ? counts : 0;
  }
  return sum;
}

/// What the points say, by directions that are independent of each other.
struct Measured {
  int directions = 0;
  Matrix6d along;     ///< one a column, of length 1
  Vector6d step_m;    ///< along each, to where the points fit best
  Vector6d variance;  ///< of it
  double recession_step_m = 0;
};

Measured measured(const Equations& now, double recession_m, double voxel_m,
                  const RefinementConfig& config) {
  Matrix7d H = Matrix7d::Zero();
  Vector7d g = Vector7d::Zero();
  const double prior = 1 / std::pow(kRecessionSigma_voxels * voxel_m, 2);
  H(6, 6) = prior;
  g[6] = prior * (recession_m - kRecession_voxels * voxel_m);
  for (const Residual& r : now.residuals) {
    H.noalias() += r.weight * r.J * r.J.transpose();
    g.noalias() += r.weight * r.off_m * r.J;
  }
  // The recession is eliminated (Schur complement).
  const Vector6d coupling = H.topRightCorner<6, 1>() / H(6, 6);
  const Matrix6d uncoupled = H.topLeftCorner<6, 6>();
  const Matrix6d H_pose = uncoupled - coupling * H.bottomLeftCorner<1, 6>();
  const Vector6d g_pose = g.head<6>() - coupling * g[6];
  const Eigen::SelfAdjointEigenSolver<Matrix6d> solver(H_pose);
  Measured result;
  const double least = 1 / (config.observed_sigma_m * config.observed_sigma_m);
  Vector6d all = Vector6d::Zero();
  for (int i = 0; i < 6; ++i) {
    const Vector6d direction = solver.eigenvectors().col(i);
    const double turning = direction.tail<3>().squaredNorm();
    double facing = 0;
    for (const Residual& r : now.residuals) {
      const double part = r.J.head<6>().dot(direction);
      const double arm_share = r.arm_m * r.arm_m / (kLever_m * kLever_m);
      const double by_rough_normals = kRoughness * kRoughness * (1 - turning + turning * arm_share);
      if (part * part > by_rough_normals) facing += r.information * part * part;
    }
    const double coupled = solver.eigenvalues()[i] / direction.dot(uncoupled * direction);
    const double trusted = facing * std::clamp(coupled, 0.0, 1.0);
    if (!(trusted > least)) continue;
    result.along.col(result.directions) = direction;
    result.step_m[result.directions] = -direction.dot(g_pose) / solver.eigenvalues()[i];
    result.variance[result.directions] = kShared * kShared / trusted;
    all += direction * result.step_m[result.directions];
    ++result.directions;
  }
  result.recession_step_m = -(g[6] + H.bottomLeftCorner<1, 6>() * all) / H(6, 6);
  return result;
}

}  // namespace

Fit fit_of(const DistanceField& field, const View& view, const Isometry& T_map_body) {
  Fit fit;
  DistanceField::Cursor cells{field};
  const double cell_m = field.cell_m();
  for (const Beam& beam : view.beams) {
    const Eigen::Vector3d end = T_map_body * beam.point_m;
    const std::uint8_t there = cells.at(field.cell_at(end));
    const double away_m =
        (there & ~DistanceField::kUnknownBit) * cell_m / DistanceField::kStepsPerCell;
    const double scale_m = std::hypot(kHit_cells * cell_m, 2 * beam.sigma_m);
    const bool hit = away_m <= scale_m;
    if (!hit && (there & DistanceField::kUnknownBit) != 0) continue;
    const double e = away_m * away_m / (scale_m * scale_m);
    ++fit.known;
    fit.hits += hit ? 1 : 0;
    fit.cost += e / (1 + e);
    if (end.z() < T_map_body.translation().z() + kStanding_m) continue;
    ++fit.standing_known;
    fit.standing_hits += hit ? 1 : 0;
  }
  if (fit.known > 0) fit.cost /= fit.known;
  return fit;
}

Refinement refine(const MapView& map, const View& view, const PoseBelief& known,
                  const MapAuthority& authority, const RefinementConfig& config) {
  Refinement result;
  result.pose = known;
  result.before = result.after = fit_of(map.field, view, known.T_map_body);
  const Vector6d lever = levers();
  const Matrix6d P = lever.asDiagonal() * known.covariance * lever.asDiagonal();
  // What the view can tell, and what it cannot.
  const Matrix6d drift = lever.asDiagonal() * authority.drift * lever.asDiagonal();
  // Nothing is known of the map more finely than its voxels.
  const double voxel_m = map.map.resolution_m();
  Vector6d map_sigma_m;
  map_sigma_m << Eigen::Vector3d::Constant(std::max(config.map_sigma_m, voxel_m)),
      Eigen::Vector3d::Constant(std::max(config.map_sigma_rad * kLever_m, voxel_m));
  const Matrix6d map_error = map_sigma_m.cwiseAbs2().asDiagonal();
  const Matrix6d with_map = lever.asDiagonal() * known.pose_with_map * lever.asDiagonal();
  const Matrix6d with_seen = drift + with_map;  // of the pose's error, with what is measured
  const Matrix6d of_seen = drift + with_map + with_map.transpose() + map_error;
  double recession_m = kRecession_voxels * voxel_m;
  double softness_m =
      std::min(config.reach_m / 2, 2 * std::sqrt(drift.diagonal().maxCoeff()) + 0.02);
  PoseBelief pose = known;
  for (int i = 0; i < config.iterations; ++i) {
    const Equations now =
        equations(map, view, authority, pose.T_map_body, recession_m, softness_m, config.reach_m);
    result.points = static_cast<int>(now.points);
    if (now.points < config.min_points) return result;
    const Measured seen = measured(now, recession_m, voxel_m, config);
    result.directions = seen.directions;
    if (seen.directions == 0) return result;
    // The measurement, as if made from where the pose was known to be.
    const Vector6d so_far = change_between(known.T_map_body, pose.T_map_body).cwiseProduct(lever);
    const Eigen::MatrixXd H = seen.along.leftCols(seen.directions).transpose();
    const Eigen::VectorXd innovation = seen.step_m.head(seen.directions) + H * so_far;
    const Eigen::MatrixXd R = seen.variance.head(seen.directions).asDiagonal();
    const Eigen::MatrixXd S = H * of_seen * H.transpose() + R;
    const Eigen::MatrixXd gain = S.ldlt().solve(H * with_seen.transpose()).transpose();
    const Vector6d change = gain * innovation;
    const Isometry T_map_body = changed_by(known.T_map_body, change.cwiseQuotient(lever));
    const Matrix6d after = P - gain * S * gain.transpose();
    const auto unlevered = lever.cwiseInverse().asDiagonal();
    // What the pose and the map share is known only roughly, so the difference may be no
    // covariance.
    pose = with_pose(known, T_map_body,
                     nearest_covariance(unlevered * after * unlevered, kLeastVariance_m2));
    pose.pose_with_map = unlevered * (with_map - gain * H * (with_map + map_error)) * unlevered;
    recession_m += seen.recession_step_m;
    const bool tight = softness_m <= kLeastSoftness_m;
    if (tight && (change - so_far).norm() < kSettled_m) break;
    softness_m = std::max(softness_m / 2, kLeastSoftness_m);
  }
  result.after = fit_of(map.field, view, pose.T_map_body);
  const bool kept_hits = result.after.hits + result.after.known / 20 >= result.before.hits;
  result.improved = kept_hits && result.after.cost < result.before.cost + kBetter;
  if (result.improved) {
    result.pose = pose;
  } else {
    result.after = result.before;
  }
  return result;
}

}  // namespace cairn::localization
