// SPDX-License-Identifier: Apache-2.0
#include "mapping/top_down.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <map>
#include <opencv2/imgproc.hpp>
#include <string>

#include "mapping/height_colours.hpp"
#include "mapping/height_range.hpp"
#include "mapping/picture_legend.hpp"

namespace cairn::mapping {
namespace {

const cv::Vec3b kUnknownColour{206, 202, 198};
const cv::Vec3b kFreeColour{255, 255, 255};
const cv::Vec3b kGroundColour{222, 234, 240};
const cv::Scalar kTrueColour{70, 190, 40};
const cv::Scalar kPerceivedColour{235, 90, 20};
constexpr int kTrueWidth_px = 7;
constexpr int kPerceivedWidth_px = 2;
constexpr double kTrueArrow_px = 34;
constexpr double kPerceivedArrow_px = 20;
/// What rises no higher than this above the lowest surfaces counts as ground.
constexpr double kGroundRise_m = 0.06;

/// Layers [min, max] of the height band.
struct Band {
  std::int32_t min_z;
  std::int32_t max_z;
  [[nodiscard]] bool holds(std::int32_t z) const { return z >= min_z && z <= max_z; }
};

Band band_of(const VoxelMap& map, const TopDownConfig& config) {
  const auto layer = [&](double height_m) {
    return static_cast<std::int32_t>(std::clamp(std::floor(height_m / map.resolution_m()),
                                                -1.0 * kVoxelLimit, 1.0 * kVoxelLimit));
  };
  return {layer(config.min_height_m), layer(config.max_height_m)};
}

/// Calls visit(VoxelIndex of the layer's first voxel, occupied bits, free bits) for every layer of
/// 8 x 8 voxels in band.
template <class Visit>
void for_each_layer(const VoxelMap& map, Band band, Visit&& visit) {
  map.grid().for_each([&](BrickIndex index, const EvidenceBrick& brick) {
    for (std::int32_t z = 0; z < kBrickSide; ++z) {
      const auto word = static_cast<std::size_t>(z);
      const VoxelIndex first{index.x * kBrickSide, index.y * kBrickSide, index.z * kBrickSide + z};
      if (!band.holds(first.z) || brick.known.words[word] == 0) continue;
      visit(first, brick.occupied.words[word],
            brick.known.words[word] & ~brick.occupied.words[word]);
    }
  });
}

/// How many voxels lie at each coordinate along one axis.
using Counts = std::map<std::int32_t, std::size_t>;

struct Interval {
  double min = 0;
  double max = 0;
};

/// Where the counts lie but for the outermost 0.2 % on either side; end of the last cell, not its
/// start.
Interval trimmed(const Counts& counts) {
  std::size_t total = 0;
  for (const auto& [at, count] : counts) total += count;
  Interval interval;
  std::size_t below = 0;
  for (const auto& [at, count] : counts) {
    if (below <= total / 500) interval.min = at;
    if (below < total - total / 500) interval.max = at + 1.0;
    below += count;
  }
  return interval;
}

/// A rectangle of the map's x-y plane, in voxels.
struct Extent {
  Interval x;
  Interval y;
};

Extent extent_of(const VoxelMap& map, Band band, const TopDownOverlay& overlay) {
  std::array<Counts, 2> occupied;
  std::array<Counts, 2> free;
  for_each_layer(
      map, band, [&](VoxelIndex first, std::uint64_t occupied_bits, std::uint64_t free_bits) {
        for (std::int32_t i = 0; i < kBrickSide; ++i) {
          const std::uint64_t column = 0x0101010101010101ULL << i;
          const std::uint64_t row = std::uint64_t{0xff} << (8 * i);
          for (auto [bits, counts] :
               {std::pair{occupied_bits, &occupied}, std::pair{free_bits, &free}}) {
            if ((bits & column) != 0) {
              (*counts)[0][first.x + i] += static_cast<std::size_t>(std::popcount(bits & column));
            }
            if ((bits & row) != 0) {
              (*counts)[1][first.y + i] += static_cast<std::size_t>(std::popcount(bits & row));
            }
          }
        }
      });
  const auto& shown = occupied[0].empty() ? free : occupied;
  Extent extent{trimmed(shown[0]), trimmed(shown[1])};
  const auto include = [&](const Eigen::Vector3d& point_m) {
    const Eigen::Vector3d point = point_m / map.resolution_m();
    if (!point.allFinite() || point.cwiseAbs().maxCoeff() > kVoxelLimit) return;
    extent.x = {std::min(extent.x.min, point.x()), std::max(extent.x.max, point.x())};
    extent.y = {std::min(extent.y.min, point.y()), std::max(extent.y.max, point.y())};
  };
  for (const auto& point : overlay.true_path) include(point);
  for (const auto& point : overlay.perceived_path) include(point);
  if (overlay.T_map_body) include(overlay.T_map_body->translation());
  return extent;
}

/// From the map's x-y plane to pixels. A cell is a square of voxels_per_cell voxels, drawn as
/// pixels_per_cell pixels.
struct Layout {
  std::int32_t first_x = 0;  ///< voxel at the left edge
  std::int32_t first_y = 0;  ///< voxel at the lower edge
  int voxels_per_cell = 1;
  int pixels_per_cell = 1;
  int cols = 0;
  int rows = 0;
  double resolution_m = 0;

  [[nodiscard]] double pixels_per_m() const {
    return pixels_per_cell / (voxels_per_cell * resolution_m);
  }
  [[nodiscard]] cv::Point2d pixel(const Eigen::Vector3d& point_m) const {
    const double scale = static_cast<double>(pixels_per_cell) / voxels_per_cell;
    return {(point_m.x() / resolution_m - first_x) * scale,
            rows * pixels_per_cell - (point_m.y() / resolution_m - first_y) * scale};
  }
};

Layout layout_of(const VoxelMap& map, const Extent& extent, int size_px) {
  constexpr double kMargin = 0.04;
  constexpr double kLeastMargin_voxels = 4;
  const double longer = std::max(extent.x.max - extent.x.min, extent.y.max - extent.y.min);
  const double margin = std::max(kMargin * longer, kLeastMargin_voxels);
  Layout layout;
  layout.resolution_m = map.resolution_m();
  layout.voxels_per_cell =
      std::max(1, static_cast<int>(std::ceil((longer + 2 * margin) / size_px)));
  const auto cells = [&](const Interval& interval) {
    return static_cast<int>(
        std::ceil((interval.max - interval.min + 2 * margin) / layout.voxels_per_cell));
  };
  layout.first_x = static_cast<std::int32_t>(std::floor(extent.x.min - margin));
  layout.first_y = static_cast<std::int32_t>(std::floor(extent.y.min - margin));
  layout.cols = cells(extent.x);
  layout.rows = cells(extent.y);
  layout.pixels_per_cell = std::max(1, size_px / std::max(layout.cols, layout.rows));
  return layout;
}

/// What lies above each cell; row 0 is the picture's uppermost.
struct Columns {
  cv::Mat_<float> occupied;      ///< voxels
  cv::Mat_<std::int32_t> top_z;  ///< highest occupied layer
  cv::Mat_<std::uint8_t> free;   ///< 1: some voxel is free
};

Columns columns_of(const VoxelMap& map, Band band, const Layout& layout) {
  Columns columns{cv::Mat_<float>(layout.rows, layout.cols, 0.0F),
                  cv::Mat_<std::int32_t>(layout.rows, layout.cols, -kVoxelLimit),
                  cv::Mat_<std::uint8_t>(layout.rows, layout.cols, std::uint8_t{0})};
  for_each_layer(map, band, [&](VoxelIndex first, std::uint64_t occupied, std::uint64_t free) {
    for (std::uint64_t bits = occupied | free; bits != 0; bits &= bits - 1) {
      const int i = std::countr_zero(bits);
      const std::int32_t x = first.x + (i & 7) - layout.first_x;
      const std::int32_t y = first.y + (i >> 3) - layout.first_y;
      const int col = x / layout.voxels_per_cell;
      const int row = layout.rows - 1 - y / layout.voxels_per_cell;
      if (x < 0 || y < 0 || col >= layout.cols || row < 0) continue;
      if ((occupied >> i & 1) == 0) {
        columns.free(row, col) = 1;
        continue;
      }
      columns.occupied(row, col) += 1;
      columns.top_z(row, col) = std::max(columns.top_z(row, col), first.z);
    }
  });
  return columns;
}

/// The count of voxels over a cell that is drawn at 63 % of full strength.
double exposure(const Columns& columns, int voxels_per_cell) {
  std::vector<float> counts;
  for (const float count : columns.occupied) {
    if (count > 0) counts.push_back(count);
  }
  if (counts.empty()) return 1;
  const auto high = counts.begin() + static_cast<std::ptrdiff_t>(counts.size() * 95 / 100);
  std::nth_element(counts.begin(), high, counts.end());
  return std::max<double>(*high / 3, 4 * voxels_per_cell);
}

cv::Vec3b mixed(cv::Vec3b from, cv::Vec3b to, double share) {
  cv::Vec3b colour;
  for (int i = 0; i < 3; ++i)
    colour[i] = cv::saturate_cast<std::uint8_t>(from[i] * (1 - share) + to[i] * share);
  return colour;
}

cv::Mat_<cv::Vec3b> paint(const Columns& columns, HeightRange heights, const Layout& layout) {
  constexpr double kFaintest = 0.35;
  const double full = exposure(columns, layout.voxels_per_cell);
  const auto ground_z =
      heights.min_z + static_cast<std::int32_t>(std::lround(kGroundRise_m / layout.resolution_m));
  cv::Mat_<cv::Vec3b> picture(columns.free.size());
  for (int row = 0; row < picture.rows; ++row) {
    for (int col = 0; col < picture.cols; ++col) {
      const float count = columns.occupied(row, col);
      if (count == 0) {
        picture(row, col) = columns.free(row, col) != 0 ? kFreeColour : kUnknownColour;
      } else if (heights.max_z > ground_z && columns.top_z(row, col) <= ground_z) {
        picture(row, col) = kGroundColour;
      } else {
        const double strength = kFaintest + (1 - kFaintest) * (1 - std::exp(-count / full));
        picture(row, col) =
            mixed(kGroundColour, height_colour(heights.share(columns.top_z(row, col))), strength);
      }
    }
  }
  return picture;
}

constexpr int kSubpixelBits = 4;

cv::Point subpixel(const cv::Point2d& point) {
  const double limit = 1e6;
  const double scale = 1 << kSubpixelBits;
  return {cv::saturate_cast<int>(std::clamp(point.x, -limit, limit) * scale),
          cv::saturate_cast<int>(std::clamp(point.y, -limit, limit) * scale)};
}

void draw_path(cv::Mat& picture, const Layout& layout, const std::vector<Eigen::Vector3d>& path,
               const cv::Scalar& colour, int thickness_px) {
  std::vector<cv::Point> points;
  for (const auto& point : path) {
    if (point.allFinite()) points.push_back(subpixel(layout.pixel(point)));
  }
  if (points.empty()) return;
  cv::polylines(picture, points, false, colour, thickness_px, cv::LINE_AA, kSubpixelBits);
  cv::circle(picture, points.front(), (thickness_px + 2) << kSubpixelBits, colour, cv::FILLED,
             cv::LINE_AA, kSubpixelBits);
}

/// Its middle is at `at`; it points along `yaw_rad`, counterclockwise from the right.
void draw_arrow(cv::Mat& picture, const cv::Point2d& at, double yaw_rad, double length_px,
                const cv::Scalar& colour) {
  const auto corner = [&](double along, double left) {
    return subpixel({at.x + length_px * (along * std::cos(yaw_rad) - left * std::sin(yaw_rad)),
                     at.y - length_px * (along * std::sin(yaw_rad) + left * std::cos(yaw_rad))});
  };
  const std::vector<cv::Point> outline{corner(0.7, 0), corner(-0.5, 0.45), corner(-0.25, 0),
                                       corner(-0.5, -0.45)};
  cv::fillPoly(picture, outline, colour, cv::LINE_AA, kSubpixelBits);
  cv::polylines(picture, outline, true, cv::Scalar{255, 255, 255}, 1, cv::LINE_AA, kSubpixelBits);
}

void draw_body(cv::Mat& picture, const Layout& layout, const std::optional<Isometry>& T_map_body,
               double length_px, const cv::Scalar& colour) {
  if (!T_map_body || !T_map_body->matrix().allFinite()) return;
  draw_arrow(picture, layout.pixel(T_map_body->translation()), yaw_rad(*T_map_body), length_px,
             colour);
}

LegendItem path_item(const cv::Scalar& colour, int width_px, double arrow_px, const char* text) {
  cv::Mat sign(24, 46, CV_8UC3, cv::Scalar{255, 255, 255});
  cv::line(sign, {2, 12}, {26, 12}, colour, width_px, cv::LINE_AA);
  draw_arrow(sign, {30, 12}, 0, std::min(arrow_px, 22.0), colour);
  return {sign, text};
}

LegendItem swatch(const cv::Vec3b& colour, const char* text) {
  cv::Mat sign(14, 14, CV_8UC3, cv::Scalar(colour));
  cv::rectangle(sign, {0, 0}, {13, 13}, cv::Scalar{170, 165, 160});
  return {sign, text};
}

LegendItem height_item(HeightRange heights, double resolution_m) {
  cv::Mat_<cv::Vec3b> sign(12, 90);
  for (int col = 0; col < sign.cols; ++col)
    sign.col(col).setTo(height_colour(static_cast<double>(col) / (sign.cols - 1)));
  // Never "-0.0".
  const auto rounded_m = [&](std::int32_t z) {
    return std::round(10 * z * resolution_m) / 10 + 0.0;
  };
  char text[48];
  std::snprintf(text, sizeof(text), "height %.1f to %.1f m", rounded_m(heights.min_z),
                rounded_m(heights.max_z + 1));
  return {sign, text};
}

std::vector<LegendItem> legend_of(const TopDownOverlay& overlay, HeightRange heights,
                                  double resolution_m) {
  std::vector<LegendItem> items;
  if (overlay.T_map_true_body || !overlay.true_path.empty())
    items.push_back(path_item(kTrueColour, kTrueWidth_px, kTrueArrow_px, "true"));
  if (overlay.T_map_body || !overlay.perceived_path.empty())
    items.push_back(
        path_item(kPerceivedColour, kPerceivedWidth_px, kPerceivedArrow_px, "perceived"));
  items.push_back(height_item(heights, resolution_m));
  items.push_back(swatch(kGroundColour, "ground"));
  items.push_back(swatch(kFreeColour, "free"));
  items.push_back(swatch(kUnknownColour, "unknown"));
  return items;
}

}  // namespace

cv::Mat render_top_down(const VoxelMap& map, const TopDownOverlay& overlay,
                        const TopDownConfig& config) {
  const Band band = band_of(map, config);
  const int size_px = std::clamp(config.size_px, 100, 8000);
  const Layout layout = layout_of(map, extent_of(map, band, overlay), size_px);
  const Columns columns = columns_of(map, band, layout);
  const HeightRange heights = occupied_heights(map);
  const cv::Mat cells = paint(columns, heights, layout);
  cv::Mat picture;
  cv::resize(cells, picture, {}, layout.pixels_per_cell, layout.pixels_per_cell, cv::INTER_NEAREST);
  draw_path(picture, layout, overlay.true_path, kTrueColour, kTrueWidth_px);
  draw_body(picture, layout, overlay.T_map_true_body, kTrueArrow_px, kTrueColour);
  draw_path(picture, layout, overlay.perceived_path, kPerceivedColour, kPerceivedWidth_px);
  draw_body(picture, layout, overlay.T_map_body, kPerceivedArrow_px, kPerceivedColour);
  return with_legend(picture, layout.pixels_per_m(),
                     legend_of(overlay, heights, layout.resolution_m));
}

}  // namespace cairn::mapping
