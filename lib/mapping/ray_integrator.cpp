// SPDX-License-Identifier: Apache-2.0
#include "mapping/ray_integrator.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

namespace cairn::mapping {
namespace {

/// Ray parameter in fixed point: the end of the ray is at kRayEnd. Whole numbers make a step of the
/// walk one compare, select and add for each axis.
constexpr double kRayEnd = 1125899906842624.0;          // 2^50
constexpr double kLongestStep = 1152921504606846976.0;  // 2^60
constexpr std::int64_t kNever = std::int64_t{1} << 62;

/// A voxel's place in its brick as three 5-bit fields that each hold 8 + coordinate, so that bit 3
/// of a field goes out when a step of one leaves the brick on either side.
class PlaceInBrick {
 public:
  static constexpr std::array<std::int64_t, 3> kUnit{1, 1 << 5, 1 << 10};
  static constexpr std::int64_t kInside = 8 * (kUnit[0] + kUnit[1] + kUnit[2]);

  explicit PlaceInBrick(VoxelIndex v)
      : fields_{kInside + (v.x & 7) * kUnit[0] + (v.y & 7) * kUnit[1] + (v.z & 7) * kUnit[2]} {}

  void step(std::int64_t by) { fields_ += by; }
  [[nodiscard]] bool inside() const { return (fields_ & kInside) == kInside; }
  [[nodiscard]] std::uint64_t bit() const {
    return std::uint64_t{1} << ((fields_ & 7) | (fields_ >> 2 & 56));
  }
  [[nodiscard]] std::size_t word() const { return static_cast<std::size_t>(fields_ >> 10 & 7); }

  /// Moves a place that has just left its brick into the next brick; gives the face that it left
  /// through.
  [[nodiscard]] std::size_t wrap() {
    const std::size_t axis = (fields_ & 8 * kUnit[0]) == 0   ? 0
                             : (fields_ & 8 * kUnit[1]) == 0 ? 1
                                                             : 2;
    const bool up = (fields_ & 16 * kUnit[axis]) != 0;
    fields_ += (up ? -8 : 8) * kUnit[axis];
    return 2 * axis + (up ? 1 : 0);
  }

 private:
  std::int64_t fields_;
};

/// One axis of the walk: the ray parameter of the next crossing, the parameter between crossings,
/// the way to step.
struct AxisWalk {
  std::int64_t next = kNever;
  std::int64_t between = 0;
  std::int64_t step = 0;
  std::int64_t crossings = 0;
};

AxisWalk axis_walk(double from, double to, std::int32_t from_cell, std::int32_t to_cell,
                   std::int64_t unit) {
  if (from_cell == to_cell) return {};
  const bool up = to_cell > from_cell;
  const double length = std::abs(to - from);
  const double first = up ? from_cell + 1.0 - from : from - from_cell;
  return {static_cast<std::int64_t>(std::min(first / length * kRayEnd, kLongestStep)),
          static_cast<std::int64_t>(std::min(kRayEnd / length, kLongestStep)), up ? unit : -unit,
          std::abs(std::int64_t{to_cell} - from_cell)};
}

/// All ones if true.
std::int64_t mask_if(bool condition) { return -static_cast<std::int64_t>(condition); }

/// The rays of one camera position.
class RayWalker {
 public:
  RayWalker(FrameBricks& frame, const Eigen::Vector3d& origin_voxels, VoxelIndex origin)
      : frame_{frame},
        origin_voxels_{origin_voxels},
        origin_{origin},
        first_brick_{frame.find_or_add(brick_of(origin))} {}

  /// Marks misses from the origin up to but without voxel `end`; `end_voxels` is a point of `end`
  /// in voxel units. Gives the brick of `end`.
  std::uint32_t walk(const Eigen::Vector3d& end_voxels, VoxelIndex end) {
    constexpr auto kUnit = PlaceInBrick::kUnit;
    AxisWalk x = axis_walk(origin_voxels_.x(), end_voxels.x(), origin_.x, end.x, kUnit[0]);
    AxisWalk y = axis_walk(origin_voxels_.y(), end_voxels.y(), origin_.y, end.y, kUnit[1]);
    AxisWalk z = axis_walk(origin_voxels_.z(), end_voxels.z(), origin_.z, end.z, kUnit[2]);
    std::int64_t left = x.crossings + y.crossings + z.crossings;
    PlaceInBrick place{origin_};
    std::uint32_t brick = first_brick_;
    while (left > 0) {
      VoxelMask& misses = frame_[brick].misses;
      do {
        misses.words[place.word()] |= place.bit();
        const std::int64_t take_x = mask_if(x.next <= y.next) & mask_if(x.next <= z.next);
        const std::int64_t take_y = ~take_x & mask_if(y.next <= z.next);
        const std::int64_t take_z = ~(take_x | take_y);
        x.next += x.between & take_x;
        y.next += y.between & take_y;
        z.next += z.between & take_z;
        place.step((x.step & take_x) | (y.step & take_y) | (z.step & take_z));
        --left;
      } while (left > 0 && place.inside());
      if (!place.inside()) brick = frame_.across(brick, place.wrap());
    }
    // Rounding may swap the last two crossings of a ray that ends within 1e-12 of an edge.
    return frame_[brick].index == brick_of(end) ? brick : frame_.find_or_add(brick_of(end));
  }

 private:
  FrameBricks& frame_;
  Eigen::Vector3d origin_voxels_;
  VoxelIndex origin_;
  std::uint32_t first_brick_;
};

Result<void> check(const stereo::DisparityImage& image, const Isometry& T_map_camera,
                   const VoxelMap& map, double max_range_m) {
  const stereo::RectifiedCamera& camera = image.camera;
  if (image.code.size() != image.disparity_16ths.size()) {
    return fail("disparity image: code plane and disparity plane differ in size");
  }
  const std::array<double, 5> numbers{camera.f_px, camera.cx_px, camera.cy_px, camera.doffs_px,
                                      camera.baseline_m};
  if (!std::all_of(numbers.begin(), numbers.end(), [](double n) { return std::isfinite(n); }) ||
      camera.f_px <= 0 || camera.baseline_m <= 0 || image.step_px < 1) {
    return fail(
        "disparity image: camera needs finite numbers, f_px, baseline_m and step_px over 0");
  }
  if (!T_map_camera.matrix().allFinite()) return fail("map pose: not finite");
  const double limit_m = (kVoxelLimit - 2) * map.resolution_m() - max_range_m;
  if (T_map_camera.translation().cwiseAbs().maxCoeff() > limit_m) {
    return fail("map pose: " + std::to_string(T_map_camera.translation().cwiseAbs().maxCoeff()) +
                " m from the origin, the map ends at " + std::to_string(limit_m) + " m");
  }
  return {};
}

}  // namespace

Result<Integration> RayIntegrator::integrate(const stereo::DisparityImage& image,
                                             const Isometry& T_map_camera, VoxelMap& map) {
  const auto checked = check(image, T_map_camera, map, config_.max_range_m);
  if (!checked) return tl::make_unexpected(checked.error());
  Integration counts;
  frame_.clear();
  cast_rays(image, T_map_camera, map, counts);
  apply(map, counts);
  return counts;
}

void RayIntegrator::cast_rays(const stereo::DisparityImage& image, const Isometry& T_map_camera,
                              const VoxelMap& map, Integration& counts) {
  const stereo::RectifiedCamera& camera = image.camera;
  const double voxels_per_m = 1.0 / map.resolution_m();
  const Eigen::Vector3d origin_m = T_map_camera.translation();
  RayWalker walker{frame_, origin_m * voxels_per_m, map.voxel_at(origin_m)};
  for (int row = 0; row < image.rows(); ++row) {
    const double y = (row * image.step_px - camera.cy_px) / camera.f_px;
    for (int col = 0; col < image.cols(); ++col) {
      if (!image.valid(row, col) || image.code(row, col) < config_.min_confidence) continue;
      const double x = (col * image.step_px - camera.cx_px) / camera.f_px;
      const double shift_px = image.disparity_px(row, col) + camera.doffs_px;
      const double slant = std::sqrt(x * x + y * y + 1);
      const double range_m = shift_px > 0 ? camera.f_px * camera.baseline_m / shift_px * slant
                                          : std::numeric_limits<double>::infinity();
      if (range_m < config_.min_range_m) continue;
      const bool hit = range_m <= config_.max_range_m;
      const double depth_m = std::min(range_m, config_.max_range_m) / slant;
      const Eigen::Vector3d end_m =
          T_map_camera * Eigen::Vector3d{x * depth_m, y * depth_m, depth_m};
      const VoxelIndex end = map.voxel_at(end_m);
      FrameBrick& last = frame_[walker.walk(end_m * voxels_per_m, end)];
      (hit ? last.hits : last.misses).set(index_in_brick(end));
      ++counts.rays;
      counts.hits += hit ? 1 : 0;
    }
  }
}

void RayIntegrator::apply(VoxelMap& map, Integration& counts) const {
  for (const FrameBrick& brick : frame_.all()) {
    VoxelMask touched = brick.misses;
    for (std::size_t z = 0; z < kBrickSide; ++z) touched.words[z] |= brick.hits.words[z];
    if (!touched.any()) continue;
    counts.voxels += static_cast<std::size_t>(touched.count());
    if (map.add_evidence(brick.index, brick.hits, brick.misses,
                         static_cast<std::uint8_t>(config_.hit_evidence),
                         static_cast<std::uint8_t>(config_.miss_evidence))) {
      counts.changed.push_back(brick.index);
    }
  }
  std::sort(counts.changed.begin(), counts.changed.end());
}

}  // namespace cairn::mapping
