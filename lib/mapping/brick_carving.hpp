// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

#include "mapping/grid_index.hpp"

namespace cairn::mapping {

/// Where the voxels of a layer of a brick (equal z, bit x + 8 y) lie from its first one, in the
/// camera's frame: x and y times the focal length [px m], depth [m].
struct LayerOffsets {
  alignas(64) std::array<float, 64> x_px_m{};
  alignas(64) std::array<float, 64> y_px_m{};
  alignas(64) std::array<float, 64> depth_m{};
};

/// A brick before a camera, and an image of how far one sees there. A voxel of depth z (of its
/// centre) is asked about where it appears: column and row of the image are
/// scale * (x_px_m / z + c).
struct BrickBeforeCamera {
  std::array<float, 3> first{};  ///< centre of voxel 0: x and y [px m], depth [m]
  std::array<float, 3> layer{};  ///< from one layer to the next
  float scale = 1;
  float cx = 0;
  float cy = 0;
  float width = 0;  ///< of the image, in its own columns
  float height = 0;
  const float* nearest_m = nullptr;
  int stride = 0;
  float half_depth_m = 0;   ///< a voxel's own reach along the depth, from its centre
  float least_depth_m = 0;  ///< what is nearer is not asked about
  float clear_to_m = 0;     ///< all voxels that end before here are free
  float hidden_from_m = 0;  ///< none that ends behind here is
};

/// The voxels that lie wholly before what is seen there.
[[nodiscard]] VoxelMask voxels_in_free_space(const BrickBeforeCamera& brick,
                                             const LayerOffsets& offsets);

}  // namespace cairn::mapping
