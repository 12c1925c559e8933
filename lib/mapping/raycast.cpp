// SPDX-License-Identifier: Apache-2.0
#include "mapping/raycast.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace cairn::mapping {
namespace {

using Cell = std::array<std::int32_t, 3>;

/// A walk from cell to cell of a grid along origin + t * direction.
class GridWalk {
 public:
  /// Stands in `cell`, which the ray enters at `t`.
  GridWalk(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, std::int32_t cell_side,
           const Cell& cell, double t)
      : cell_{cell}, t_{t} {
    for (std::size_t i = 0; i < 3; ++i) {
      const auto axis = static_cast<Eigen::Index>(i);
      const bool up = direction[axis] > 0;
      const double border = static_cast<double>(cell[i] + (up ? 1 : 0)) * cell_side;
      step_[i] = up ? 1 : -1;
      between_[i] = cell_side / std::abs(direction[axis]);
      next_[i] = direction[axis] == 0 ? std::numeric_limits<double>::infinity()
                                      : (border - origin[axis]) / direction[axis];
    }
  }

  [[nodiscard]] const Cell& cell() const { return cell_; }
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
  Cell cell_;
  Cell step_{};
  std::array<double, 3> next_{};
  std::array<double, 3> between_{};
  double t_;
};

/// A ray in voxel units; direction of length 1.
struct Ray {
  Eigen::Vector3d origin;
  Eigen::Vector3d direction;
  double max_t = 0;

  [[nodiscard]] std::int32_t cell(double t, std::size_t axis) const {
    const auto i = static_cast<Eigen::Index>(axis);
    return static_cast<std::int32_t>(std::floor(origin[i] + t * direction[i]));
  }
};

struct Entry {
  double t = 0;
  VoxelIndex voxel;
};

/// The first occupied voxel of a brick that the ray enters at `t`.
std::optional<Entry> first_in_brick(const Ray& ray, const Cell& brick, double t,
                                    const VoxelMask& occupied) {
  Cell cell{};
  for (std::size_t i = 0; i < 3; ++i) {
    cell[i] = std::clamp(ray.cell(t, i), brick[i] * kBrickSide, brick[i] * kBrickSide + 7);
  }
  for (GridWalk walk{ray.origin, ray.direction, 1, cell, t}; walk.t() <= ray.max_t;
       walk.advance()) {
    const VoxelIndex voxel{walk.cell()[0], walk.cell()[1], walk.cell()[2]};
    if (brick_of(voxel) != BrickIndex{brick[0], brick[1], brick[2]}) break;
    if (occupied.test(index_in_brick(voxel))) return Entry{walk.t(), voxel};
  }
  return std::nullopt;
}

template <class Grid>
std::optional<RaycastHit> raycast_in(const Grid& grid, double resolution_m,
                                     const Eigen::Vector3d& origin_m, const Eigen::Vector3d& along,
                                     double max_range_m) {
  const double length = along.norm();
  if (!origin_m.allFinite() || !std::isfinite(length) || length == 0 || !(max_range_m >= 0)) {
    return std::nullopt;
  }
  const Ray ray{origin_m / resolution_m, along / length, max_range_m / resolution_m};
  if (!(ray.origin.cwiseAbs().maxCoeff() + ray.max_t < kVoxelLimit - 2)) return std::nullopt;
  const Cell start{ray.cell(0, 0) >> 3, ray.cell(0, 1) >> 3, ray.cell(0, 2) >> 3};
  typename Grid::Cursor bricks{grid};
  for (GridWalk walk{ray.origin, ray.direction, kBrickSide, start, 0}; walk.t() <= ray.max_t;
       walk.advance()) {
    const auto* brick = bricks.find({walk.cell()[0], walk.cell()[1], walk.cell()[2]});
    if (brick == nullptr || !brick->occupied.any()) continue;
    const auto entry = first_in_brick(ray, walk.cell(), walk.t(), brick->occupied);
    if (entry) return RaycastHit{entry->t * resolution_m, entry->voxel};
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
