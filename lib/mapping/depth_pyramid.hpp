// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "mapping/ray_grid.hpp"

namespace cairn::mapping {

/// How far one may look without meeting anything, in ever larger cells: cell (row, col) of level n
/// stands for the pixels from (row, col) * 2^n up to before (row + 1, col + 1) * 2^n. A pixel of
/// level 0 takes the nearest end of the rays in its 3 x 3 neighbourhood, if it has a ray itself: an
/// edge of a near thing and ground at a grazing angle are so taken at their nearest.
class DepthPyramid {
 public:
  struct Level {
    int rows = 0;
    int cols = 0;
    std::vector<float> nearest_m;   ///< of the cell's rays, the nearest end; 0: there are none
    std::vector<float> farthest_m;  ///< of its level 0 pixels, the farthest; 0: there are none
    /// The least level at which every cell in here has a ray; over this level: none has.
    std::vector<int> gapless_from;
  };

  /// What a rectangle of cells says together.
  struct View {
    float nearest_m = 0;
    float farthest_m = 0;
    int gapless_from = 0;
  };

  void build(const RayGrid& rays);

  [[nodiscard]] int levels() const { return static_cast<int>(levels_.size()); }
  [[nodiscard]] const Level& level(int n) const { return levels_[static_cast<std::size_t>(n)]; }
  /// Of the whole image.
  [[nodiscard]] float farthest_m() const { return levels_.back().farthest_m.front(); }

  /// Rows and columns are of level n and lie in it; the last ones belong to the rectangle.
  [[nodiscard]] View over(int n, int first_row, int last_row, int first_col, int last_col) const;

 private:
  void take_nearest_around(const RayGrid& rays);
  void halve(int n);

  std::vector<Level> levels_;
  cv::Mat_<float> ends_m_;
  cv::Mat_<float> nearest_end_m_;
};

}  // namespace cairn::mapping
