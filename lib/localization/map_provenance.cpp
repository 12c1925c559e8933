// SPDX-License-Identifier: Apache-2.0
#include "localization/map_provenance.hpp"

#include <algorithm>
#include <utility>

#include "localization/covariance.hpp"

namespace cairn::localization {
namespace {

/// A place is 4 cells of the field a side.
constexpr int kPlaceShift = 2;
/// A beam finds a surface that is within so many cells of its end.
constexpr double kFound_cells = 1.25;
/// Poses nearer to each other than this share an origin.
constexpr double kNewOrigin_m = 0.1;

mapping::VoxelIndex place_of(CellIndex cell) {
  return {cell.x >> kPlaceShift, cell.y >> kPlaceShift, cell.z >> kPlaceShift};
}

/// The covariance of the pose that results when a pose at `from_m` is carried to `to_m` without
/// error: the heading's uncertainty swings the position.
Matrix6d carried(const Matrix6d& covariance, const Eigen::Vector3d& from_m,
                 const Eigen::Vector3d& to_m) {
  const Eigen::Vector3d way = to_m - from_m;
  Matrix6d carry = Matrix6d::Identity();
  carry.block<3, 3>(0, 3) << 0, way.z(), -way.y(), -way.z(), 0, way.x(), way.y(), -way.x(), 0;
  return carry * covariance * carry.transpose();
}

double size_m2(const Matrix6d& covariance) {
  return covariance.diagonal().head<3>().sum() +
         kLever_m * kLever_m * covariance.diagonal().tail<3>().sum();
}

}  // namespace

void MapProvenance::start(const PoseBelief& reference) {
  places_ = {};
  made_ = {{reference.T_map_body.translation(), reference.covariance}};
}

MapProvenance::Origin MapProvenance::origin_now(const PoseBelief& belief) {
  const Eigen::Vector3d at_m = belief.T_map_body.translation();
  const Made& last = made_.back();
  const bool same = made_.size() > 1 && (at_m - last.at_m).norm() < kNewOrigin_m &&
                    size_m2(belief.covariance) < 1.1 * size_m2(last.covariance);
  if (!same) made_.push_back({at_m, belief.covariance});
  return kFirst + static_cast<Origin>(made_.size()) - 1;
}

MapAuthority MapProvenance::look(const DistanceField& field, const View& view,
                                 const PoseBelief& belief) {
  MapAuthority authority;
  authority.shares.assign(view.beams.size(), 0);
  std::vector<Origin> origins(view.beams.size(), kNothingThere);
  DistanceField::Cursor cells{field};
  for (std::size_t i = 0; i < view.beams.size(); ++i) {
    const CellIndex cell = field.cell_at(belief.T_map_body * view.beams[i].point_m);
    const mapping::VoxelIndex place = place_of(cell);
    if (!mapping::within(mapping::brick_of(place), mapping::kBrickLimit)) continue;
    Origin& origin =
        places_.find_or_add(mapping::brick_of(place)).origin[mapping::index_in_brick(place)];
    const double away_cells = static_cast<double>(cells.at(cell) & ~DistanceField::kUnknownBit) /
                              DistanceField::kStepsPerCell;
    const bool found = away_cells <= kFound_cells;
    if (origin == kNeverLooked) {
      origin = found ? kFirst : kNothingThere;
    } else if (origin == kNothingThere && found) {
      origin = origin_now(belief);
    }
    origins[i] = origin;
  }
  std::vector<Matrix6d> drifts;
  std::vector<double> sizes;
  std::vector<std::pair<Origin, std::size_t>> seen;
  double largest = 0;
  std::vector<std::size_t> which(origins.size(), 0);
  for (std::size_t i = 0; i < origins.size(); ++i) {
    if (origins[i] < kFirst) continue;
    const auto known = std::find_if(seen.begin(), seen.end(),
                                    [&](const auto& one) { return one.first == origins[i]; });
    if (known != seen.end()) {
      which[i] = known->second;
      continue;
    }
    const Made& made = made_[static_cast<std::size_t>(origins[i] - kFirst)];
    drifts.push_back(belief.covariance -
                     carried(made.covariance, made.at_m, belief.T_map_body.translation()));
    sizes.push_back(std::max(0.0, size_m2(drifts.back())));
    largest = std::max(largest, sizes.back());
    which[i] = drifts.size() - 1;
    seen.emplace_back(origins[i], which[i]);
  }
  if (largest <= 0) return authority;
  Matrix6d sum = Matrix6d::Zero();
  double shares = 0;
  for (std::size_t i = 0; i < origins.size(); ++i) {
    if (origins[i] < kFirst) continue;
    authority.shares[i] = sizes[which[i]] / largest;
    sum += authority.shares[i] * drifts[which[i]];
    shares += authority.shares[i];
  }
  authority.drift = nearest_covariance(sum / shares, 0);
  return authority;
}

}  // namespace cairn::localization
