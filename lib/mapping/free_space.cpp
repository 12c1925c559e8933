// SPDX-License-Identifier: Apache-2.0
#include "mapping/free_space.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace cairn::mapping {
namespace {

/// Cubes begin so large that about this many span the view along each axis.
constexpr int kLargestCubes = 8;
constexpr int kLargestCubeBricks = 8;
/// A cube is judged by the pyramid's level at which it spans at most so many cells each way.
constexpr int kCellsAcross = 4;
/// Pixels; what rounding may move.
constexpr double kSlack_px = 0.01;

struct Interval {
  int first = 0;
  int last = -1;
};

}  // namespace

FreeSpaceFinder::FreeSpaceFinder(const RayGrid& rays, const DepthPyramid& pyramid,
                                 const Isometry& T_map_camera, double resolution_m, double reach_m)
    : pyramid_{pyramid},
      resolution_m_{resolution_m},
      reach_m_{reach_m},
      f_px_{rays.f_px},
      cx_px_{rays.cx_px},
      cy_px_{rays.cy_px},
      rows_{rays.end_depth_m.rows},
      cols_{rays.end_depth_m.cols},
      R_camera_map_{T_map_camera.linear().transpose()},
      origin_m_{T_map_camera.translation()},
      half_size_{R_camera_map_.cwiseAbs().rowwise().sum()},
      half_depth_m_{0.5 * resolution_m * half_size_.z()} {
  for (std::size_t i = 0; i < 64; ++i) {
    const VoxelIndex voxel = voxel_in({0, 0, 0}, static_cast<int>(i));
    const Eigen::Vector3d offset_m =
        R_camera_map_ * Eigen::Vector3d(voxel.x, voxel.y, 0) * resolution_m;
    offsets_.x_px_m[i] = static_cast<float>(f_px_ * offset_m.x());
    offsets_.y_px_m[i] = static_cast<float>(f_px_ * offset_m.y());
    offsets_.depth_m[i] = static_cast<float>(offset_m.z());
  }
}

void FreeSpaceFinder::find(FreeSpace& found) {
  found.whole.clear();
  found.parts.clear();
  const double depth_m = pyramid_.farthest_m();
  Eigen::AlignedBox3d view(origin_m_);
  for (const double u_px : {-0.5, cols_ - 0.5}) {
    for (const double v_px : {-0.5, rows_ - 0.5}) {
      const Eigen::Vector3d corner_m =
          depth_m * Eigen::Vector3d((u_px - cx_px_) / f_px_, (v_px - cy_px_) / f_px_, 1);
      view.extend(origin_m_ + R_camera_map_.transpose() * corner_m);
    }
  }
  const Eigen::Vector3d reach_m = Eigen::Vector3d::Constant(reach_m_);
  view.clamp(Eigen::AlignedBox3d(origin_m_ - reach_m, origin_m_ + reach_m));
  const double brick_m = kBrickSide * resolution_m_;
  int side = kLargestCubeBricks;
  while (view.sizes().maxCoeff() > kLargestCubes * side * brick_m && side < kBrickLimit) side *= 2;
  const auto cube_at = [&](double m) {
    const double cube = std::floor(m / (side * brick_m));
    const double limit = kBrickLimit / side;
    return static_cast<int>(std::clamp(cube, -limit, limit - 1));
  };
  for (int z = cube_at(view.min().z()); z <= cube_at(view.max().z()); ++z) {
    for (int y = cube_at(view.min().y()); y <= cube_at(view.max().y()); ++y) {
      for (int x = cube_at(view.min().x()); x <= cube_at(view.max().x()); ++x) {
        visit({{x * side, y * side, z * side}, side}, found);
      }
    }
  }
}

FreeSpaceFinder::Extent FreeSpaceFinder::extent_of(const Cube& cube) const {
  const double voxels = kBrickSide * cube.side;
  const Eigen::Vector3d low(cube.low.x, cube.low.y, cube.low.z);
  const Eigen::Vector3d middle_m =
      resolution_m_ * (kBrickSide * low + Eigen::Vector3d::Constant(0.5 * voxels));
  Extent extent;
  extent.middle_m = R_camera_map_ * (middle_m - origin_m_);
  extent.half_m = 0.5 * (voxels - 1) * resolution_m_;
  extent.near_m = extent.middle_m.z() - extent.half_m * half_size_.z();
  extent.far_m = extent.middle_m.z() + extent.half_m * half_size_.z();
  return extent;
}

int FreeSpaceFinder::level_at(double depth_m) const {
  const double width_px = f_px_ * resolution_m_ / depth_m;
  const auto whole_px = static_cast<unsigned>(std::clamp(width_px, 1.0, 65536.0));
  return std::min(static_cast<int>(std::bit_width(whole_px)) - 1, pyramid_.levels() - 1);
}

bool FreeSpaceFinder::out_of_view_sideways(const Extent& extent) const {
  const auto beside = [&](double middle_m, double half_m, double c_px, int pixels) {
    const double low = std::min(0.0, (-0.5 - c_px) / f_px_) * extent.far_m;
    const double high = std::max(0.0, (pixels - 0.5 - c_px) / f_px_) * extent.far_m;
    return middle_m + half_m < low || middle_m - half_m > high;
  };
  return beside(extent.middle_m.x(), extent.half_m * half_size_.x(), cx_px_, cols_) ||
         beside(extent.middle_m.y(), extent.half_m * half_size_.y(), cy_px_, rows_);
}

FreeSpaceFinder::Verdict FreeSpaceFinder::judge(const Cube& cube, const Extent& extent) {
  seen_whole_ = false;
  seen_.farthest_m = pyramid_.farthest_m();
  if (extent.far_m <= resolution_m_ || extent.near_m + half_depth_m_ >= seen_.farthest_m ||
      out_of_view_sideways(extent)) {
    return Verdict::kNothing;
  }
  if (extent.near_m <= resolution_m_) return Verdict::kMixed;
  // A point of the cube that is d from its middle m appears (d.x - m.x / m.z * d.z) / (m.z + d.z)
  // times f beside it.
  seen_whole_ = true;
  const auto where = [&](int axis, double c_px, int pixels) {
    const double slope = extent.middle_m[axis] / extent.middle_m.z();
    const double beside_m =
        extent.half_m * (R_camera_map_.row(axis) - slope * R_camera_map_.row(2)).cwiseAbs().sum();
    const double radius_px = f_px_ * beside_m / extent.near_m + kSlack_px;
    const double at_px = f_px_ * slope + c_px + 0.5;
    const double first = std::clamp(std::floor(at_px - radius_px), -1.0, 1.0 * pixels);
    const double last = std::clamp(std::floor(at_px + radius_px), -1.0, 1.0 * pixels);
    seen_whole_ = seen_whole_ && first >= 0 && last < pixels;
    return Interval{static_cast<int>(std::max(first, 0.0)),
                    static_cast<int>(std::min(last, pixels - 1.0))};
  };
  const Interval col = where(0, cx_px_, cols_);
  const Interval row = where(1, cy_px_, rows_);
  if (col.first > col.last || row.first > row.last) return Verdict::kNothing;
  const bool is_brick = cube.side == 1;
  int level = level_at(is_brick ? extent.middle_m.z() : extent.near_m);
  while ((col.last >> level) - (col.first >> level) >= kCellsAcross ||
         (row.last >> level) - (row.first >> level) >= kCellsAcross) {
    ++level;
  }
  seen_ = pyramid_.over(level, row.first >> level, row.last >> level, col.first >> level,
                        col.last >> level);
  if (extent.near_m + half_depth_m_ >= seen_.farthest_m) return Verdict::kNothing;
  const int finest = level_at(is_brick ? extent.middle_m.z() : extent.far_m);
  seen_whole_ = seen_whole_ && seen_.gapless_from <= finest;
  return seen_whole_ && extent.far_m + half_depth_m_ < seen_.nearest_m ? Verdict::kFree
                                                                       : Verdict::kMixed;
}

void FreeSpaceFinder::visit(const Cube& cube, FreeSpace& found) {
  const Extent extent = extent_of(cube);
  const Verdict verdict = judge(cube, extent);
  if (verdict == Verdict::kNothing) return;
  if (verdict == Verdict::kMixed && cube.side == 1) return carve(cube.low, extent, found);
  const int step = verdict == Verdict::kMixed ? cube.side / 2 : 1;
  for (int z = 0; z < cube.side; z += step) {
    for (int y = 0; y < cube.side; y += step) {
      for (int x = 0; x < cube.side; x += step) {
        const BrickIndex low{cube.low.x + x, cube.low.y + y, cube.low.z + z};
        verdict == Verdict::kMixed ? visit({low, step}, found) : found.whole.push_back(low);
      }
    }
  }
}

void FreeSpaceFinder::carve(BrickIndex brick, const Extent& extent, FreeSpace& found) const {
  const int level = level_at(std::max(extent.middle_m.z(), resolution_m_));
  const Eigen::Vector3d first_m = extent.middle_m - extent.half_m * R_camera_map_.rowwise().sum();
  const Eigen::Vector3d layer_m = resolution_m_ * R_camera_map_.col(2);
  const double scale = std::ldexp(1.0, -level);
  const auto in_px = [&](const Eigen::Vector3d& m) {
    return std::array<float, 3>{static_cast<float>(f_px_ * m.x()),
                                static_cast<float>(f_px_ * m.y()), static_cast<float>(m.z())};
  };
  const DepthPyramid::Level& cells = pyramid_.level(level);
  BrickBeforeCamera view;
  view.first = in_px(first_m);
  view.layer = in_px(layer_m);
  view.scale = static_cast<float>(scale);
  view.cx = static_cast<float>(scale * (cx_px_ + 0.5));
  view.cy = static_cast<float>(scale * (cy_px_ + 0.5));
  view.width = static_cast<float>(scale * cols_);
  view.height = static_cast<float>(scale * rows_);
  view.nearest_m = cells.nearest_m.data();
  view.stride = cells.cols;
  view.half_depth_m = static_cast<float>(half_depth_m_);
  view.least_depth_m = static_cast<float>(resolution_m_);
  view.clear_to_m = seen_whole_ ? seen_.nearest_m : 0;
  view.hidden_from_m = seen_.farthest_m;
  const VoxelMask free = voxels_in_free_space(view, offsets_);
  if (free.any()) found.parts.push_back({brick, free});
}

}  // namespace cairn::mapping
