// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>

#include "mapping/ray_grid.hpp"

namespace cairn::mapping {

/// Where rays need not be walked, since other rays meet every voxel that they meet there.
///
/// Near the camera rays lie so close that a voxel is met by many. Take those whose row and column
/// are multiples of m = 2, 4, 8 ... A voxel of a given side that a ray meets at depth z appears as
/// a convex figure that holds the ray's pixel p, and a disc of radius r = f * side / (2 * depth of
/// its middle) around its middle, which is at most kappa * r from p, where kappa = sqrt(3) over the
/// cosine of p's angle from the third axis. With both the figure holds a cone; in that, once r is
/// over m / sqrt(2), a disc of just that radius whose middle is at most kappa * m / sqrt(2) from p;
/// and in that a point of the lattice of m. The ray through it meets the voxel too, if it ends
/// behind. It may have been spared itself, but by a coarser lattice only: in the end by a ray that
/// is walked.
class RayShortcuts {
 public:
  /// For voxels of this side, however they are turned.
  void find(const RayGrid& grid, double voxel_m);

  /// The depth that the ray may be spared up to from kFromVoxels sides on; 0: nothing.
  [[nodiscard]] double until_m(int row, int col) const { return until_m_(row, col); }

  /// In sides of a voxel: nearer ones may reach behind the camera.
  static constexpr double kFromVoxels = 2;

 private:
  void spare_by_lattice(const RayGrid& grid, int pitch, int reach, double limit_m, double behind_m);

  cv::Mat_<double> until_m_;
  cv::Mat_<double> nearest_end_m_;
  cv::Mat_<double> row_nearest_end_m_;
};

}  // namespace cairn::mapping
