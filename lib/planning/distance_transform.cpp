// SPDX-License-Identifier: Apache-2.0
#include "planning/distance_transform.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace cairn::planning {
namespace {

// Squares of distances in cells stay below this; it stands for "nothing marked".
constexpr float kFar = 1e9F;

/// Lower envelope of the parabolas (q - i)^2 + f[i], equations of section 2.1.
class LineTransform {
 public:
  explicit LineTransform(std::size_t longest) : at_(longest), from_(longest + 1), out_(longest) {}

  const std::vector<float>& run(const float* f, std::size_t n, std::size_t stride) {
    std::size_t last = 0;
    at_[0] = 0;
    from_[0] = -std::numeric_limits<float>::infinity();
    from_[1] = std::numeric_limits<float>::infinity();
    for (std::size_t q = 1; q < n; ++q) {
      float s = crossing(f, stride, at_[last], q);
      while (s <= from_[last]) s = crossing(f, stride, at_[--last], q);
      at_[++last] = q;
      from_[last] = s;
      from_[last + 1] = std::numeric_limits<float>::infinity();
    }
    std::size_t k = 0;
    for (std::size_t q = 0; q < n; ++q) {
      while (from_[k + 1] < static_cast<float>(q)) ++k;
      const float d = static_cast<float>(q) - static_cast<float>(at_[k]);
      out_[q] = d * d + f[at_[k] * stride];
    }
    return out_;
  }

 private:
  static float crossing(const float* f, std::size_t stride, std::size_t a, std::size_t b) {
    const auto x = static_cast<double>(a);
    const auto y = static_cast<double>(b);
    return static_cast<float>(((f[b * stride] + y * y) - (f[a * stride] + x * x)) / (2 * (y - x)));
  }

  std::vector<std::size_t> at_;
  std::vector<float> from_;
  std::vector<float> out_;
};

}  // namespace

CellGrid<float> distance_to_marked_m(const CellBox& box, const std::vector<std::uint8_t>& marked) {
  CellGrid<float> grid(box, kFar);
  const auto width = static_cast<std::size_t>(box.width);
  const auto height = static_cast<std::size_t>(box.height);
  for (std::size_t i = 0; i < marked.size(); ++i) {
    if (marked[i] != 0) grid.values[i] = 0;
  }
  if (grid.values.empty()) return grid;
  LineTransform line(std::max(width, height));
  for (std::size_t x = 0; x < width; ++x) {
    const std::vector<float>& column = line.run(&grid.values[x], height, width);
    for (std::size_t y = 0; y < height; ++y) grid.values[y * width + x] = column[y];
  }
  for (std::size_t y = 0; y < height; ++y) {
    const std::vector<float>& row = line.run(&grid.values[y * width], width, 1);
    for (std::size_t x = 0; x < width; ++x) {
      grid.values[y * width + x] = row[x] >= kFar ? std::numeric_limits<float>::infinity()
                                                  : std::sqrt(row[x]) * static_cast<float>(kCell_m);
    }
  }
  return grid;
}

}  // namespace cairn::planning
