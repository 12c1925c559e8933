// SPDX-License-Identifier: Apache-2.0
#include "mapping/raycast.hpp"

#include <array>
#include <cmath>
#include <limits>

namespace cairn::mapping {
namespace {

/// A walk from cell to cell of a grid of side 1 along origin + t * direction.
class GridWalk {
 public:
  GridWalk(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, VoxelIndex start,
           double t)
      : cell_{start.x, start.y, start.z}, t_{t} {
    for (std::size_t i = 0; i < 3; ++i) {
      const auto axis = static_cast<Eigen::Index>(i);
      step_[i] = direction[axis] > 0 ? 1 : -1;
      between_[i] = 1 / std::abs(direction[axis]);
      const double ahead =
          direction[axis] > 0 ? cell_[i] + 1.0 - origin[axis] : origin[axis] - cell_[i];
      next_[i] =
          direction[axis] == 0 ? std::numeric_limits<double>::infinity() : ahead * between_[i];
    }
  }

  [[nodiscard]] VoxelIndex cell() const { return {cell_[0], cell_[1], cell_[2]}; }
  /// Where the ray entered the cell.
  [[nodiscard]] double t() const { return t_; }
  void advance() {
    const std::size_t i =
        next_[0] <= next_[1] ? (next_[0] <= next_[2] ? 0 : 2) : (next_[1] <= next_[2] ? 1 : 2);
    t_ = next_[i];
    cell_[i] += step_[i];
    next_[i] += between_[i];
  }

 private:
  std::array<std::int32_t, 3> cell_;
  std::array<std::int32_t, 3> step_{};
  std::array<double, 3> next_{};
  std::array<double, 3> between_{};
  double t_;
};

VoxelIndex cell_around(const Eigen::Vector3d& point) {
  return {static_cast<std::int32_t>(std::floor(point.x())),
          static_cast<std::int32_t>(std::floor(point.y())),
          static_cast<std::int32_t>(std::floor(point.z()))};
}

template <class Grid>
std::optional<RaycastHit> raycast_in(const Grid& grid, double resolution_m,
                                     const Eigen::Vector3d& origin_m, const Eigen::Vector3d& along,
                                     double max_range_m) {
  const double length = along.norm();
  if (!origin_m.allFinite() || !std::isfinite(length) || length == 0 || !(max_range_m >= 0)) {
    return std::nullopt;
  }
  const Eigen::Vector3d origin = origin_m / resolution_m;
  const Eigen::Vector3d direction = along / length;
  const double max_t = max_range_m / resolution_m;
  if (!(origin.cwiseAbs().maxCoeff() + max_t < kVoxelLimit - 2)) return std::nullopt;
  typename Grid::Cursor bricks{grid};
  for (GridWalk walk{origin, direction, cell_around(origin), 0}; walk.t() <= max_t;
       walk.advance()) {
    const auto* brick = bricks.find(brick_of(walk.cell()));
    if (brick != nullptr && brick->occupied.test(index_in_brick(walk.cell()))) {
      return RaycastHit{walk.t() * resolution_m, walk.cell()};
    }
  }
  return std::nullopt;
}

}  // namespace

std::optional<RaycastHit> raycast(const VoxelMap& map, const Eigen::Vector3d& origin_m,
                                  const Eigen::Vector3d& direction, double max_range_m) {
  return raycast_in(map.grid(), map.resolution_m(), origin_m, direction, max_range_m);
}

std::optional<RaycastHit> raycast(const MapReplica& map, const Eigen::Vector3d& origin_m,
                                  const Eigen::Vector3d& direction, double max_range_m) {
  if (map.map_id() == 0) return std::nullopt;
  return raycast_in(map.grid(), map.resolution_m(), origin_m, direction, max_range_m);
}

}  // namespace cairn::mapping
