// SPDX-License-Identifier: Apache-2.0
#include "mapping/depth_pyramid.hpp"

#include <algorithm>
#include <bit>
#include <limits>
#include <opencv2/imgproc.hpp>

namespace cairn::mapping {
namespace {

constexpr float kNone = std::numeric_limits<float>::infinity();

void resize(DepthPyramid::Level& level, int rows, int cols) {
  level.rows = rows;
  level.cols = cols;
  const auto cells = static_cast<std::size_t>(rows) * static_cast<std::size_t>(cols);
  level.nearest_m.resize(cells);
  level.farthest_m.resize(cells);
  level.gapless_from.resize(cells);
}

}  // namespace

void DepthPyramid::build(const RayGrid& rays) {
  const int rows = rays.end_depth_m.rows;
  const int cols = rays.end_depth_m.cols;
  const auto longest = static_cast<unsigned>(std::max({rows, cols, 1}));
  levels_.resize(static_cast<std::size_t>(std::bit_width(longest - 1)) + 1);
  resize(levels_[0], rows, cols);
  take_nearest_around(rays);
  for (int n = 1; n < levels(); ++n) {
    resize(levels_[static_cast<std::size_t>(n)], (level(n - 1).rows + 1) / 2,
           (level(n - 1).cols + 1) / 2);
    halve(n);
  }
}

void DepthPyramid::take_nearest_around(const RayGrid& rays) {
  Level& level = levels_[0];
  cv::Mat_<float> ends_m(level.rows, level.cols);
  for (int row = 0; row < level.rows; ++row) {
    const double* from = rays.end_depth_m[row];
    float* to = ends_m[row];
    for (int col = 0; col < level.cols; ++col) {
      to[col] = from[col] == 0 ? kNone : static_cast<float>(from[col]);
    }
  }
  cv::Mat_<float> nearest_m;
  cv::erode(ends_m, nearest_m, cv::Mat());
  std::size_t at = 0;
  for (int row = 0; row < level.rows; ++row) {
    for (int col = 0; col < level.cols; ++col, ++at) {
      const bool has_ray = ends_m(row, col) != kNone;
      level.nearest_m[at] = has_ray ? nearest_m(row, col) : 0;
      level.farthest_m[at] = level.nearest_m[at];
      level.gapless_from[at] = has_ray ? 0 : 1;
    }
  }
}

void DepthPyramid::halve(int n) {
  const Level& fine = level(n - 1);
  Level& coarse = levels_[static_cast<std::size_t>(n)];
  std::size_t at = 0;
  for (int row = 0; row < coarse.rows; ++row) {
    for (int col = 0; col < coarse.cols; ++col, ++at) {
      const int last_row = std::min(2 * row + 1, fine.rows - 1);
      const int last_col = std::min(2 * col + 1, fine.cols - 1);
      float nearest = kNone;
      float farthest = 0;
      int gapless_from = 0;
      for (int r = 2 * row; r <= last_row; ++r) {
        for (int c = 2 * col; c <= last_col; ++c) {
          const auto i = static_cast<std::size_t>(r * fine.cols + c);
          if (fine.nearest_m[i] != 0) nearest = std::min(nearest, fine.nearest_m[i]);
          farthest = std::max(farthest, fine.farthest_m[i]);
          gapless_from = std::max(gapless_from, fine.gapless_from[i]);
        }
      }
      coarse.nearest_m[at] = nearest == kNone ? 0 : nearest;
      coarse.farthest_m[at] = farthest;
      coarse.gapless_from[at] = nearest == kNone ? n + 1 : gapless_from;
    }
  }
}

DepthPyramid::View DepthPyramid::over(int n, int first_row, int last_row, int first_col,
                                      int last_col) const {
  const Level& cells = level(n);
  View view{kNone, 0, 0};
  for (int row = first_row; row <= last_row; ++row) {
    const auto start = static_cast<std::size_t>(row * cells.cols);
    for (auto i = start + static_cast<std::size_t>(first_col);
         i <= start + static_cast<std::size_t>(last_col); ++i) {
      view.nearest_m = std::min(view.nearest_m, cells.nearest_m[i]);
      view.farthest_m = std::max(view.farthest_m, cells.farthest_m[i]);
      view.gapless_from = std::max(view.gapless_from, cells.gapless_from[i]);
    }
  }
  return view;
}

}  // namespace cairn::mapping
