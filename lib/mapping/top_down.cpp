// SPDX-License-Identifier: Apache-2.0
#include "mapping/top_down.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <map>
#include <opencv2/imgproc.hpp>
#include <string>

#include "mapping/height_colours.hpp"
#include "mapping/height_range.hpp"

namespace cairn::mapping {
namespace {

const cv::Vec3b kUnknownColour{206, 202, 198};
const cv::Vec3b kFreeColour{253, 252, 251};
const cv::Scalar kTrueColour{60, 160, 20};
const cv::Scalar kPerceivedColour{235, 110, 20};
const cv::Scalar kInk{60, 50, 45};

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

cv::Mat_<cv::Vec3b> paint(const Columns& columns, HeightRange heights, int voxels_per_cell) {
  constexpr double kFaintest = 0.15;
  const double full = exposure(columns, voxels_per_cell);
  cv::Mat_<cv::Vec3b> picture(columns.free.size());
  for (int row = 0; row < picture.rows; ++row) {
    for (int col = 0; col < picture.cols; ++col) {
      const cv::Vec3b ground = columns.free(row, col) != 0 ? kFreeColour : kUnknownColour;
      const float count = columns.occupied(row, col);
      const double strength =
          count > 0 ? kFaintest + (1 - kFaintest) * (1 - std::exp(-count / full)) : 0;
      const cv::Vec3b top = height_colour(heights.share(columns.top_z(row, col)));
      for (int i = 0; i < 3; ++i) {
        picture(row, col)[i] =
            cv::saturate_cast<std::uint8_t>(ground[i] * (1 - strength) + top[i] * strength);
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

void draw_arrow(cv::Mat& picture, const Layout& layout, const Isometry& T_map_body) {
  if (!T_map_body.matrix().allFinite()) return;
  constexpr double kLength_px = 22;
  const cv::Point2d at = layout.pixel(T_map_body.translation());
  const double yaw = yaw_rad(T_map_body);
  const auto corner = [&](double along, double left) {
    return subpixel({at.x + kLength_px * (along * std::cos(yaw) - left * std::sin(yaw)),
                     at.y - kLength_px * (along * std::sin(yaw) + left * std::cos(yaw))});
  };
  const std::vector<cv::Point> outline{corner(0.7, 0), corner(-0.5, 0.45), corner(-0.25, 0),
                                       corner(-0.5, -0.45)};
  cv::fillPoly(picture, outline, kPerceivedColour, cv::LINE_AA, kSubpixelBits);
  cv::polylines(picture, outline, true, cv::Scalar{255, 255, 255}, 1, cv::LINE_AA, kSubpixelBits);
}

/// The longest of 1, 2, 5 times a power of ten that is no longer than this.
double round_length_m(double longest_m) {
  const double power = std::pow(10, std::floor(std::log10(longest_m)));
  for (const double factor : {5.0, 2.0}) {
    if (factor * power <= longest_m) return factor * power;
  }
  return power;
}

std::string length_text(double length_m) {
  if (length_m >= 1) return std::to_string(std::lround(length_m)) + " m";
  if (length_m >= 0.01) return std::to_string(std::lround(length_m * 100)) + " cm";
  return std::to_string(std::lround(length_m * 1000)) + " mm";
}

/// In a strip of its own below the map, so that it covers nothing.
cv::Mat with_scale_bar(const cv::Mat& picture, const Layout& layout) {
  constexpr int kStrip_px = 40;
  constexpr int kInset_px = 14;
  cv::Mat framed;
  cv::copyMakeBorder(picture, framed, 0, kStrip_px, 0, 0, cv::BORDER_CONSTANT,
                     cv::Scalar{255, 255, 255});
  const double length_m = round_length_m(0.25 * picture.cols / layout.pixels_per_m());
  const int length_px = static_cast<int>(std::lround(length_m * layout.pixels_per_m()));
  const int y = picture.rows + kStrip_px / 2;
  cv::rectangle(framed, {kInset_px, y - 3}, {kInset_px + length_px, y + 2}, kInk, cv::FILLED);
  cv::putText(framed, length_text(length_m), {kInset_px + length_px + 10, y + 6},
              cv::FONT_HERSHEY_SIMPLEX, 0.55, kInk, 1, cv::LINE_AA);
  return framed;
}

}  // namespace

cv::Mat render_top_down(const VoxelMap& map, const TopDownOverlay& overlay,
                        const TopDownConfig& config) {
  const Band band = band_of(map, config);
  const int size_px = std::clamp(config.size_px, 100, 8000);
  const Layout layout = layout_of(map, extent_of(map, band, overlay), size_px);
  const Columns columns = columns_of(map, band, layout);
  const cv::Mat cells = paint(columns, occupied_heights(map), layout.voxels_per_cell);
  cv::Mat picture;
  cv::resize(cells, picture, {}, layout.pixels_per_cell, layout.pixels_per_cell, cv::INTER_NEAREST);
  draw_path(picture, layout, overlay.true_path, kTrueColour, 4);
  draw_path(picture, layout, overlay.perceived_path, kPerceivedColour, 2);
  if (overlay.T_map_body) draw_arrow(picture, layout, *overlay.T_map_body);
  return with_scale_bar(picture, layout);
}

}  // namespace cairn::mapping
