// SPDX-License-Identifier: Apache-2.0
#include "mapping/ray_walker.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace cairn::mapping {
namespace {

/// Coordinates within a brick as fixed point: whole voxels above kFraction bits.
constexpr int kFraction = 48;
constexpr std::int64_t kOne = std::int64_t{1} << kFraction;
/// Fewer layers are walked.
constexpr std::int32_t kWorthALeap = 4;
/// Of one leap, so that the way sideways fits its 64 bits.
constexpr std::int32_t kLongestLeap = 1 << 13;

std::int64_t fixed(double voxels) {
  return static_cast<std::int64_t>(voxels * static_cast<double>(kOne));
}

std::int64_t cell_of(std::int64_t coordinate) { return coordinate >> kFraction; }

/// How far along its axis a coordinate is from the cell border ahead of it.
double to_border(std::int64_t coordinate, std::int64_t slope) {
  const std::int64_t into_cell = coordinate & (kOne - 1);
  return static_cast<double>(slope > 0 ? kOne - into_cell : into_cell);
}

std::array<std::int32_t, 3> array_of(const BrickIndex& b) { return {b.x, b.y, b.z}; }

/// A ray on its way through the layers across its longest axis. u and v are the other two axes, in
/// their order.
template <int kAxis>
class LayerWalk {
 public:
  static constexpr std::size_t kU = kAxis == 0 ? 1 : 0;
  static constexpr std::size_t kV = kAxis == 2 ? 1 : 2;

  LayerWalk(FrameBricks& frame, std::uint32_t brick, std::int32_t first_layer, bool up,
            double u_slope, double v_slope)
      : frame_{frame},
        brick_{brick},
        layer_{first_layer & 7},
        step_{up ? 1 : -1},
        u_slope_{fixed(u_slope)},
        v_slope_{fixed(v_slope)} {}

  [[nodiscard]] std::uint32_t brick() const { return brick_; }

  /// A coordinate of the map relative to the present brick.
  [[nodiscard]] std::int64_t local_u(double u) const { return local<kU>(u); }
  [[nodiscard]] std::int64_t local_v(double v) const { return local<kV>(v); }

  void start_at(std::int64_t u, std::int64_t v) {
    u_ = u;
    v_ = v;
  }

  /// Marks what the ray meets on its way to (u, v) in this layer, and stands there.
  void cross_layer_to(std::int64_t u, std::int64_t v) {
    std::int64_t u_cell = cell_of(u_);
    std::int64_t v_cell = cell_of(v_);
    mark(u_cell, v_cell);
    const bool both = u_cell != cell_of(u) && v_cell != cell_of(v);
    if (both ? u_crosses_first(u_, v_) : u_cell != cell_of(u)) step_cell<kU>(u_cell, v_cell, u);
    if (v_cell != cell_of(v)) step_cell<kV>(v_cell, u_cell, v);
    while (u_cell != cell_of(u)) step_cell<kU>(u_cell, v_cell, u);
    while (v_cell != cell_of(v)) step_cell<kV>(v_cell, u_cell, v);
    start_at(u, v);
  }

  void next_layer() {
    layer_ += step_;
    if ((layer_ & ~7) == 0) return;
    layer_ &= 7;
    brick_ = frame_.across(brick_, 2 * kAxis + (step_ > 0 ? 1 : 0));
  }

  /// Crosses this many whole layers.
  void cross_layers(std::int32_t count) {
    while (count > 0) {
      count -= cross_within_brick(std::min(count, step_ > 0 ? 8 - layer_ : layer_ + 1));
      if (count == 0) return;
      if (leaves_brick()) {
        cross_layer_to(u_ + u_slope_, v_ + v_slope_);
        next_layer();
        --count;
      }
    }
  }

  /// Stands where crossing this many whole layers ends, to the last bit, and marks nothing.
  void leap(std::int32_t count) {
    for (; count > kLongestLeap; count -= kLongestLeap) leap(kLongestLeap);
    const std::int64_t u = u_ + count * u_slope_;
    const std::int64_t v = v_ + count * v_slope_;
    const std::int32_t layer = layer_ + count * step_;
    BrickIndex there = frame_[brick_].index;
    const std::array<std::int32_t*, 3> coordinates{&there.x, &there.y, &there.z};
    *coordinates[kAxis] += layer >> 3;
    *coordinates[kU] += static_cast<std::int32_t>(cell_of(u) >> 3);
    *coordinates[kV] += static_cast<std::int32_t>(cell_of(v) >> 3);
    brick_ = frame_.find_or_add(there);
    layer_ = layer & 7;
    start_at(u & kWithinBrick, v & kWithinBrick);
  }

 private:
  static constexpr std::int64_t kWithinBrick = kBrickSide * kOne - 1;

  template <std::size_t kOther>
  [[nodiscard]] std::int64_t local(double coordinate) const {
    return fixed(coordinate - kBrickSide * array_of(frame_[brick_].index)[kOther]);
  }

  [[nodiscard]] bool leaves_brick() const {
    return ((cell_of(u_ + u_slope_) | cell_of(v_ + v_slope_)) & ~std::int64_t{7}) != 0;
  }

  void mark(std::int64_t u_cell, std::int64_t v_cell) {
    frame_[brick_].misses.words[kAxis][static_cast<std::size_t>(layer_)] |=
        std::uint64_t{1} << (u_cell | v_cell << 3);
  }

  /// One cell towards `target`, and marks it; both become relative to the brick that this leads
  /// into.
  template <std::size_t kOther>
  void step_cell(std::int64_t& cell, std::int64_t across_cell, std::int64_t& target) {
    const bool up = cell_of(target) > cell;
    cell += up ? 1 : -1;
    if ((cell & ~std::int64_t{7}) != 0) {
      cell &= 7;
      target += (up ? -kBrickSide : kBrickSide) * kOne;
      brick_ = frame_.across(brick_, 2 * kOther + (up ? 1 : 0));
    }
    kOther == kU ? mark(cell, across_cell) : mark(across_cell, cell);
  }

  /// Crosses up to `count` layers of the present brick, as long as the ray stays in it sideways;
  /// gives how many.
  std::int32_t cross_within_brick(std::int32_t count) {
    std::uint64_t* const words = frame_[brick_].misses.words[kAxis].data();
    std::int64_t u = u_;
    std::int64_t v = v_;
    std::int32_t layer = layer_;
    std::int64_t cell = cell_of(u) | cell_of(v) << 3;
    std::int32_t crossed = 0;
    for (; crossed < count; ++crossed) {
      const std::int64_t next_u = u + u_slope_;
      const std::int64_t next_v = v + v_slope_;
      if (((cell_of(next_u) | cell_of(next_v)) & ~std::int64_t{7}) != 0) break;
      const std::int64_t next_cell = cell_of(next_u) | cell_of(next_v) << 3;
      std::uint64_t bits = std::uint64_t{1} << cell | std::uint64_t{1} << next_cell;
      const std::int64_t changed = cell ^ next_cell;
      // One branch, seldom taken: each half alone would be a coin toss.
      if (((changed & 7) * (changed >> 3)) != 0) {
        bits |= std::uint64_t{1} << corner(u, v, cell, next_cell);
      }
      words[layer] |= bits;
      layer += step_;
      u = next_u;
      v = next_v;
      cell = next_cell;
    }
    start_at(u, v);
    layer_ = layer;
    if (crossed > 0 && (layer & ~7) != 0) {
      layer_ -= step_;
      next_layer();
    }
    return crossed;
  }

  /// The cell between two that differ in u and in v.
  [[nodiscard]] std::int64_t corner(std::int64_t u, std::int64_t v, std::int64_t cell,
                                    std::int64_t next_cell) const {
    return u_crosses_first(u, v) ? (next_cell & 7) | (cell & 56) : (cell & 7) | (next_cell & 56);
  }

  [[nodiscard]] bool u_crosses_first(std::int64_t u, std::int64_t v) const {
    return to_border(u, u_slope_) * std::abs(static_cast<double>(v_slope_)) <=
           to_border(v, v_slope_) * std::abs(static_cast<double>(u_slope_));
  }

  FrameBricks& frame_;
  std::uint32_t brick_;
  std::int32_t layer_;  ///< in the present brick
  std::int32_t step_;
  std::int64_t u_slope_;  ///< per layer; at most 1 either way
  std::int64_t v_slope_;
  std::int64_t u_ = 0;  ///< where the ray enters the layer, relative to the present brick
  std::int64_t v_ = 0;
};

}  // namespace

template <int kAxis>
std::uint32_t RayWalker::walk_along(const Eigen::Vector3d& end_voxels, std::int32_t planes,
                                    const Part& spared) {
  using Walk = LayerWalk<kAxis>;
  const Eigen::Vector3d along = end_voxels - origin_voxels_;
  const double length = std::abs(along[kAxis]);
  const double u_slope = length > 0 ? along[Walk::kU] / length : 0;
  const double v_slope = length > 0 ? along[Walk::kV] / length : 0;
  const std::int32_t layer = std::array{origin_.x, origin_.y, origin_.z}[kAxis];
  Walk walk{frame_, first_brick_, layer, planes > 0, u_slope, v_slope};
  const double u = origin_voxels_[Walk::kU];
  const double v = origin_voxels_[Walk::kV];
  walk.start_at(walk.local_u(u), walk.local_v(v));
  if (planes != 0) {
    const double a = origin_voxels_[kAxis];
    const double to_plane = planes > 0 ? layer + 1.0 - a : a - layer;
    walk.cross_layer_to(walk.local_u(u + u_slope * to_plane), walk.local_v(v + v_slope * to_plane));
    walk.next_layer();
    const std::int32_t whole = std::abs(planes) - 1;
    const auto layers_until = [&](double share) {
      return std::clamp(share * length - to_plane, 0.0, static_cast<double>(whole));
    };
    const auto from = static_cast<std::int32_t>(std::ceil(layers_until(spared.from)));
    const auto to = static_cast<std::int32_t>(layers_until(spared.to));
    if (to - from >= kWorthALeap) {
      walk.cross_layers(from);
      walk.leap(to - from);
      walk.cross_layers(whole - to);
    } else {
      walk.cross_layers(whole);
    }
  }
  walk.cross_layer_to(walk.local_u(end_voxels[Walk::kU]), walk.local_v(end_voxels[Walk::kV]));
  return walk.brick();
}

std::uint32_t RayWalker::walk(const Eigen::Vector3d& end_voxels, VoxelIndex end,
                              const Part& spared) {
  const Eigen::Vector3d along = (end_voxels - origin_voxels_).cwiseAbs();
  std::uint32_t brick = 0;
  if (along.x() >= along.y() && along.x() >= along.z()) {
    brick = walk_along<0>(end_voxels, end.x - origin_.x, spared);
  } else if (along.y() >= along.z()) {
    brick = walk_along<1>(end_voxels, end.y - origin_.y, spared);
  } else {
    brick = walk_along<2>(end_voxels, end.z - origin_.z, spared);
  }
  return frame_[brick].index == brick_of(end) ? brick : frame_.find_or_add(brick_of(end));
}

}  // namespace cairn::mapping
