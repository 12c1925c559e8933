// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/geometry.hpp"
#include "localization/distance_field.hpp"
#include "mapping/map_replica.hpp"

namespace cairn::localization {

/// What the occupied voxels near a point are like: a piece of a wall, or of a rod.
struct SurfacePatch {
  Eigen::Vector3d middle_m = Eigen::Vector3d::Zero();
  /// Directions across it, of length 1: one for a wall, two for a rod.
  Eigen::Vector3d across[2] = {Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
  double sigma_m[2] = {0, 0};  ///< spread of the voxels along each
  int directions = 0;
};

/// Fits planes and lines to the map's voxels, in cubes of 3 x 3 x 3 cells of the field. Remembers
/// them until the map changes.
class Surfaces {
 public:
  Surfaces() : slots_(kSlots) {}

  /// The surface near `point_m`, as the voxels within 1.5 cells of it (along each axis) show it.
  /// Nothing where they are too few, or lie like neither a wall nor a rod. Good until the next
  /// call.
  [[nodiscard]] const SurfacePatch* near(const Eigen::Vector3d& point_m, const DistanceField& field,
                                         const mapping::MapReplica& map);

 private:
  static constexpr std::size_t kSlots = 8192;
  struct Slot {
    std::uint64_t version = 0;  ///< of the field; 0: empty
    CellIndex cell;
    std::optional<SurfacePatch> patch;
  };
  std::vector<Slot> slots_;
};

}  // namespace cairn::localization
