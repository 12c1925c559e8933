// SPDX-License-Identifier: Apache-2.0
#include "mapping/ray_shortcuts.hpp"

#include <algorithm>
#include <cmath>

namespace cairn::mapping {
namespace {

constexpr double kHalfDiagonal = 0.8660254037844387;  // of a voxel, in sides
constexpr double kSlack = 1.001;
constexpr int kCoarsestPitch = 16;
constexpr int kMaxReach = 8;

/// Of the ray that is farthest from the third axis.
double steepest(const RayGrid& grid) {
  const double x = std::max(std::abs(grid.cx_px), std::abs(grid.end_depth_m.cols - grid.cx_px));
  const double y = std::max(std::abs(grid.cy_px), std::abs(grid.end_depth_m.rows - grid.cy_px));
  return std::hypot(1.0, x / grid.f_px, y / grid.f_px);
}

}  // namespace

void RayShortcuts::find(const RayGrid& grid, double voxel_m) {
  until_m_.create(grid.end_depth_m.size());
  until_m_.setTo(0);
  const double kappa = 2 * kHalfDiagonal * steepest(grid);
  const int reach = static_cast<int>(std::ceil(kSlack * (kappa + 1) / std::sqrt(2.0)));
  if (reach > kMaxReach) return;
  const double behind_m = kSlack * 2 * kHalfDiagonal * voxel_m;
  for (int pitch = 2; pitch <= kCoarsestPitch; pitch *= 2) {
    const double disc_until_m = grid.f_px * voxel_m / (kSlack * std::sqrt(2.0) * pitch);
    const double limit_m = disc_until_m - kSlack * kHalfDiagonal * voxel_m;
    if (limit_m < 2 * kFromVoxels * voxel_m) return;
    spare_by_lattice(grid, pitch, reach, limit_m, behind_m);
  }
}

void RayShortcuts::spare_by_lattice(const RayGrid& grid, int pitch, int reach, double limit_m,
                                    double behind_m) {
  const cv::Mat_<double>& end_m = grid.end_depth_m;
  const int rows = end_m.rows / pitch;
  const int cols = end_m.cols / pitch;
  // Over the lattice points up to `reach` pitches from any pixel of a cell: first along rows.
  const int before = reach - 1;
  const int after = reach;
  row_nearest_end_m_.create(rows, cols);
  nearest_end_m_.create(rows, cols);
  for (int row = 0; row < rows; ++row) {
    for (int col = 0; col < cols; ++col) {
      double nearest = 0;
      if (col >= before && col + after < cols) {
        nearest = end_m(pitch * row, pitch * (col - before));
        for (int i = col - before + 1; i <= col + after; ++i)
          nearest = std::min(nearest, end_m(pitch * row, pitch * i));
      }
      row_nearest_end_m_(row, col) = nearest;
    }
  }
  for (int row = 0; row < rows; ++row) {
    for (int col = 0; col < cols; ++col) {
      double nearest = 0;
      if (row >= before && row + after < rows) {
        nearest = row_nearest_end_m_(row - before, col);
        for (int i = row - before + 1; i <= row + after; ++i)
          nearest = std::min(nearest, row_nearest_end_m_(i, col));
      }
      nearest_end_m_(row, col) = std::min(limit_m, nearest - behind_m);
    }
  }
  for (int row = 0; row < rows * pitch; ++row) {
    const double* nearest = nearest_end_m_[row / pitch];
    double* until = until_m_[row];
    const bool on_row = row % pitch == 0;
    for (int col = 0; col < cols * pitch; ++col) {
      if (on_row && col % pitch == 0) continue;
      until[col] = std::max(until[col], nearest[col / pitch]);
    }
  }
}

}  // namespace cairn::mapping
