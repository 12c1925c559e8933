// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "core/geometry.hpp"
#include "mapping/brick_carving.hpp"
#include "mapping/depth_pyramid.hpp"
#include "mapping/grid_index.hpp"
#include "mapping/ray_grid.hpp"

namespace cairn::mapping {

/// What one frame sees to be free, in an order that depends on nothing but the frame.
struct FreeSpace {
  struct Part {
    BrickIndex index;
    VoxelMask free;
  };

  std::vector<BrickIndex> whole;  ///< bricks of which every voxel is free
  std::vector<Part> parts;        ///< bricks of which some are
};

/// Finds the free space before a depth image by holding cubes of the map against it, the largest
/// first. What is decided for a cube is what would be decided for each of its voxels: a voxel is
/// free if its centre appears in a cell of the pyramid that has rays and the voxel ends before them
/// all. The cell is of the level at which a voxel at the middle of its brick is one to two cells
/// wide, or of level 0.
class FreeSpaceFinder {
 public:
  /// rays: those that the pyramid was built of. resolution_m: side of a voxel. Nothing is looked
  /// for farther than reach_m along an axis of the map, but for the rest of a largest cube there:
  /// what a frame may cost does not depend on its camera.
  FreeSpaceFinder(const RayGrid& rays, const DepthPyramid& pyramid, const Isometry& T_map_camera,
                  double resolution_m, double reach_m);

  /// Puts it in the place of what was there.
  void find(FreeSpace& found);

 private:
  /// side x side x side bricks.
  struct Cube {
    BrickIndex low;
    int side = 1;
  };
  enum class Verdict { kNothing, kFree, kMixed };
  /// Where a cube's voxels (their centres) lie.
  struct Extent {
    Eigen::Vector3d middle_m;  ///< in the camera's frame
    double half_m = 0;         ///< of the cube, along its own axes
    double near_m = 0;         ///< depths
    double far_m = 0;
  };

  [[nodiscard]] Extent extent_of(const Cube& cube) const;
  [[nodiscard]] int level_at(double depth_m) const;
  [[nodiscard]] bool out_of_view_sideways(const Extent& extent) const;
  [[nodiscard]] Verdict judge(const Cube& cube, const Extent& extent);
  void visit(const Cube& cube, FreeSpace& found);
  void carve(BrickIndex brick, const Extent& extent, FreeSpace& found) const;

  const DepthPyramid& pyramid_;
  double resolution_m_;
  double reach_m_;
  double f_px_;
  double cx_px_;
  double cy_px_;
  int rows_;
  int cols_;
  Eigen::Matrix3d R_camera_map_;
  Eigen::Vector3d origin_m_;
  Eigen::Vector3d half_size_;  ///< of a cube of half side 1 along the camera's axes
  double half_depth_m_;        ///< of a voxel
  LayerOffsets offsets_;
  DepthPyramid::View seen_;  ///< where the cube last judged appears
  bool seen_whole_ = false;  ///< it lies in the image entirely
};

}  // namespace cairn::mapping
