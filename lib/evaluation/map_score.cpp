// SPDX-License-Identifier: Apache-2.0
#include "evaluation/map_score.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <unordered_map>

namespace cairn::evaluation {
namespace {

using Cell = Eigen::Vector3i;

Cell cell_of(const Eigen::Vector3d& point, double size_m) {
  return (point / size_m).array().floor().cast<int>();
}

std::uint64_t key_of(const Cell& cell) {
  constexpr std::uint64_t kMask = (1U << 21) - 1;
  const auto part = [](int value) { return static_cast<std::uint64_t>(value) & kMask; };
  return part(cell.x()) | part(cell.y()) << 21 | part(cell.z()) << 42;
}

/// Points in cubic cells, for neighbour queries within one cell's size.
class PointGrid {
 public:
  explicit PointGrid(double cell_m) : cell_m_{cell_m} {}

  void add(const Eigen::Vector3d& point) {
    cells_[key_of(cell_of(point, cell_m_))].push_back(point);
  }

  /// Squared distance to the nearest point, if that is within `radius_m` <= the cell size; else
  /// infinity.
  [[nodiscard]] double nearest_squared_m2(const Eigen::Vector3d& point, double radius_m) const {
    const Eigen::Vector3d reach = Eigen::Vector3d::Constant(radius_m);
    const Cell low = cell_of(point - reach, cell_m_);
    const Cell high = cell_of(point + reach, cell_m_);
    double best = std::numeric_limits<double>::infinity();
    for (int z = low.z(); z <= high.z(); ++z) {
      for (int y = low.y(); y <= high.y(); ++y) {
        for (int x = low.x(); x <= high.x(); ++x) {
          const auto cell = cells_.find(key_of({x, y, z}));
          if (cell == cells_.end()) continue;
          for (const Eigen::Vector3d& other : cell->second) {
            best = std::min(best, (other - point).squaredNorm());
          }
        }
      }
    }
    return best <= radius_m * radius_m ? best : std::numeric_limits<double>::infinity();
  }

 private:
  double cell_m_;
  std::unordered_map<std::uint64_t, std::vector<Eigen::Vector3d>> cells_;
};

std::optional<double> share(double part, double whole) {
  if (!(whole > 0)) return std::nullopt;
  return part / whole;
}

}  // namespace

DistanceFunction distance_to_samples(std::span<const Eigen::Vector3d> samples, double limit_m) {
  auto grid = std::make_shared<PointGrid>(limit_m);
  for (const Eigen::Vector3d& sample : samples) grid->add(sample);
  return [grid, limit_m](const Eigen::Vector3d& point) {
    return std::min(limit_m, std::sqrt(grid->nearest_squared_m2(point, limit_m)));
  };
}

struct MapScorer::State {
  const MapTruth& truth;
  MapScoreConfig config;
  std::map<int, PointGrid> occupied;  ///< by size in finest voxels
  std::uint64_t occupied_voxels = 0;
  double true_positive = 0;
  double false_positive = 0;
  std::uint64_t free_voxels = 0;
  std::uint64_t false_free = 0;

  [[nodiscard]] int multiple(double size_m) const {
    return std::max(1, static_cast<int>(std::lround(size_m / config.resolution_m)));
  }
  [[nodiscard]] double tolerance_m(int multiple) const {
    return config.tolerance_m + 0.5 * (multiple - 1) * config.resolution_m;
  }

  void add_free_cube(const Eigen::Vector3d& centre, int multiple);
  [[nodiscard]] bool recalled(const Eigen::Vector3d& sample) const;
};

void MapScorer::State::add_free_cube(const Eigen::Vector3d& centre, int multiple) {
  const double distance_m = truth.distance_m(centre);
  const double reach_m = 0.5 * (multiple - 1) * config.resolution_m * std::numbers::sqrt3;
  const double half_m = 0.5 * config.resolution_m;
  const auto volume = static_cast<std::uint64_t>(multiple) * static_cast<std::uint64_t>(multiple) *
                      static_cast<std::uint64_t>(multiple);
  if (distance_m - reach_m >= half_m || distance_m + reach_m < half_m) {
    free_voxels += volume;
    if (distance_m < half_m) false_free += volume;
    return;
  }
  const int parts = multiple % 2 == 0 ? 2 : multiple;
  const double step_m = multiple * config.resolution_m / parts;
  for (int z = 0; z < parts; ++z) {
    for (int y = 0; y < parts; ++y) {
      for (int x = 0; x < parts; ++x) {
        const Eigen::Vector3d offset = Eigen::Vector3d(x, y, z).array() - 0.5 * (parts - 1);
        add_free_cube(centre + step_m * offset, multiple / parts);
      }
    }
  }
}

bool MapScorer::State::recalled(const Eigen::Vector3d& sample) const {
  return std::any_of(occupied.begin(), occupied.end(), [&](const auto& level) {
    return std::isfinite(level.second.nearest_squared_m2(sample, tolerance_m(level.first)));
  });
}

MapScorer::MapScorer(const MapTruth& truth, const MapScoreConfig& config)
    : state_{new State{truth, config, {}, 0, 0, 0, 0, 0}} {}
MapScorer::~MapScorer() = default;

void MapScorer::add_occupied(const Voxel& voxel) {
  const int multiple = state_->multiple(voxel.size_m);
  const double tolerance_m = state_->tolerance_m(multiple);
  const double weight = static_cast<double>(multiple) * multiple;
  const bool precise = std::abs(state_->truth.distance_m(voxel.centre)) <= tolerance_m;
  (precise ? state_->true_positive : state_->false_positive) += weight;
  state_->occupied.try_emplace(multiple, tolerance_m).first->second.add(voxel.centre);
  ++state_->occupied_voxels;
}

void MapScorer::add_free(const Voxel& voxel) {
  state_->add_free_cube(voxel.centre, state_->multiple(voxel.size_m));
}

MapScore MapScorer::score() const {
  const State& s = *state_;
  std::size_t recalled = 0;
  std::unordered_map<std::uint64_t, bool> recalled_voxels;
  for (const Eigen::Vector3d& sample : s.truth.observable_surface) {
    const bool here = s.recalled(sample);
    recalled += here;
    recalled_voxels[key_of(cell_of(sample, s.config.resolution_m))] |= here;
  }
  const auto false_negative =
      static_cast<double>(std::count_if(recalled_voxels.begin(), recalled_voxels.end(),
                                        [](const auto& voxel) { return !voxel.second; }));
  MapScore score;
  score.resolution_m = s.config.resolution_m;
  score.tolerance_m = s.config.tolerance_m;
  score.occupied_voxels = s.occupied_voxels;
  score.free_voxels = s.free_voxels;
  score.precision = share(s.true_positive, s.true_positive + s.false_positive);
  score.recall =
      share(static_cast<double>(recalled), static_cast<double>(s.truth.observable_surface.size()));
  score.iou = share(s.true_positive, s.true_positive + s.false_positive + false_negative);
  score.false_free_rate =
      share(static_cast<double>(s.false_free), static_cast<double>(s.free_voxels));
  return score;
}

MapScore score_map(const MapTruth& truth, const MapScoreConfig& config,
                   std::span<const Eigen::Vector3d> occupied_centres,
                   std::span<const Eigen::Vector3d> free_centres) {
  MapScorer scorer(truth, config);
  for (const Eigen::Vector3d& centre : occupied_centres) {
    scorer.add_occupied({centre, config.resolution_m});
  }
  for (const Eigen::Vector3d& centre : free_centres) {
    scorer.add_free({centre, config.resolution_m});
  }
  return scorer.score();
}

}  // namespace cairn::evaluation
