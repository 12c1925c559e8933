// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "mapping/grid_index.hpp"

namespace cairn::mapping {

/// One kind of evidence of a brick's voxels, in the order of index_in_brick.
struct alignas(64) EvidencePlane {
  std::array<std::uint8_t, kBrickVoxels> of{};

  /// Adds to the evidence of these voxels; stops at 255.
  void add(const VoxelMask& voxels, std::uint8_t evidence);
  /// The voxels with at least this much; none if it is over 255.
  [[nodiscard]] VoxelMask at_least(int evidence) const;

  friend bool operator==(const EvidencePlane&, const EvidencePlane&) = default;
};

}  // namespace cairn::mapping
