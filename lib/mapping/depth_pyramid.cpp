// SPDX-License-Identifier: Apache-2.0
#include "mapping/depth_pyramid.hpp"

#include <algorithm>
#include <array>
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
  ends_m_.create(level.rows, level.cols);
  for (int row = 0; row < level.rows; ++row) {
    const double* const from = rays.end_depth_m[row];
    float* const to = ends_m_[row];
    for (int col = 0; col < level.cols; ++col) {
      to[col] = from[col] == 0 ? kNone : static_cast<float>(from[col]);
    }
  }
  cv::erode(ends_m_, nearest_end_m_, cv::Mat());
  std::size_t at = 0;
  for (int row = 0; row < level.rows; ++row) {
    const float* const end = ends_m_[row];
    const float* const nearest = nearest_end_m_[row];
    for (int col = 0; col < level.cols; ++col, ++at) {
      const bool has_ray = end[col] != kNone;
      level.nearest_m[at] = has_ray ? nearest[col] : 0;
      level.farthest_m[at] = level.nearest_m[at];
      level.gapless_from[at] = has_ray ? 0 : 1;
    }
  }
}

void DepthPyramid::halve(int n) {
  const Level& fine = level(n - 1);
  Level& coarse = levels_[static_cast<std::size_t>(n)];
  const auto or_none = [](float end_m) { return end_m == 0 ? kNone : end_m; };
  std::size_t at = 0;
  for (int row = 0; row < coarse.rows; ++row) {
    // Where the finer level ends halfway through a cell, its last row or column is taken twice.
    const auto upper = static_cast<std::size_t>(2 * row * fine.cols);
    const auto lower = static_cast<std::size_t>(std::min(2 * row + 1, fine.rows - 1) * fine.cols);
    for (int col = 0; col < coarse.cols; ++col, ++at) {
      const auto left = static_cast<std::size_t>(2 * col);
      const auto right = static_cast<std::size_t>(std::min(2 * col + 1, fine.cols - 1));
      const std::array<std::size_t, 4> i{upper + left, upper + right, lower + left, lower + right};
      const auto& nearest_m = fine.nearest_m;
      const auto& farthest_m = fine.farthest_m;
      const auto& gapless = fine.gapless_from;
      const float nearest = std::min(std::min(or_none(nearest_m[i[0]]), or_none(nearest_m[i[1]])),
                                     std::min(or_none(nearest_m[i[2]]), or_none(nearest_m[i[3]])));
      const bool has_ray = nearest != kNone;
      coarse.nearest_m[at] = has_ray ? nearest : 0;
      coarse.farthest_m[at] = std::max(std::max(farthest_m[i[0]], farthest_m[i[1]]),
                                       std::max(farthest_m[i[2]], farthest_m[i[3]]));
      const int gapless_from =
          std::max(std::max(gapless[i[0]], gapless[i[1]]), std::max(gapless[i[2]], gapless[i[3]]));
      coarse.gapless_from[at] = has_ray ? gapless_from : n + 1;
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
