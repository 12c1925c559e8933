// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <functional>
#include <map>
#include <vector>

#include "mapping/map_replica.hpp"
#include "planning/traversability.hpp"

namespace cairn::testing {

/// A map written voxel by voxel, as a reader of deltas has it.
class MadeMap {
 public:
  explicit MadeMap(double resolution_m) : resolution_m_{resolution_m} {}

  void set(const Eigen::Vector3d& point_m, mapping::VoxelClass what) {
    const auto index = [&](double metres) {
      return static_cast<std::int32_t>(std::floor(metres / resolution_m_));
    };
    const mapping::VoxelIndex voxel{index(point_m.x()), index(point_m.y()), index(point_m.z())};
    mapping::BrickClasses& brick = bricks_[mapping::brick_of(voxel)];
    brick.brick = mapping::brick_of(voxel);
    const auto i = static_cast<std::size_t>(mapping::index_in_brick(voxel));
    const auto shift = static_cast<unsigned>(2 * (i % 4));
    brick.classes[i / 4] = static_cast<std::uint8_t>((brick.classes[i / 4] & ~(3U << shift)) |
                                                     static_cast<unsigned>(what) << shift);
  }

  /// Every voxel whose middle lies in the box [low, high).
  void fill(const Eigen::Vector3d& low_m, const Eigen::Vector3d& high_m,
            mapping::VoxelClass what = mapping::VoxelClass::kOccupied) {
    for (double z = first(low_m.z()); z < high_m.z(); z += resolution_m_) {
      for (double y = first(low_m.y()); y < high_m.y(); y += resolution_m_) {
        for (double x = first(low_m.x()); x < high_m.x(); x += resolution_m_) set({x, y, z}, what);
      }
    }
  }

  /// Floor as stereo sees it: the two layers that meet at its height, over a square.
  void floor(double from_m, double to_m, const std::function<double(double, double)>& height_m) {
    for (double y = first(from_m); y < to_m; y += resolution_m_) {
      for (double x = first(from_m); x < to_m; x += resolution_m_) {
        const double z = height_m(x, y);
        set({x, y, z + 0.25 * resolution_m_}, mapping::VoxelClass::kOccupied);
        set({x, y, z - 0.25 * resolution_m_}, mapping::VoxelClass::kOccupied);
      }
    }
  }

  /// Sends all that was set since the last time.
  [[nodiscard]] std::vector<mapping::BrickIndex> send(mapping::MapReplica& replica) {
    mapping::MapDelta delta;
    delta.map_id = 1;
    delta.complete_through = ++utime_;
    delta.resolution_m = resolution_m_;
    for (const auto& [index, brick] : bricks_) delta.bricks.push_back(brick);
    (void)replica.apply(delta).value();
    return replica.take_changes().bricks;
  }

 private:
  [[nodiscard]] double first(double low_m) const {
    return (std::ceil(low_m / resolution_m_ - 0.5) + 0.5) * resolution_m_;
  }

  double resolution_m_;
  Utime utime_ = 0;
  std::map<mapping::BrickIndex, mapping::BrickClasses> bricks_;
};

}  // namespace cairn::testing
