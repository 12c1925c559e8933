// SPDX-License-Identifier: Apache-2.0
#include "simulation/visibility.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace cairn::simulation {
namespace {

constexpr int kBlock_px = 8;
/// A block counts as touched by an edge that passes this near.
constexpr float kMargin_px = 2;
constexpr double kNear_m = 0.01;
/// An edge this little behind a face, as a share of the depth, counts as before it.
constexpr float kTolerance = 1e-3F;
/// A block's own mark, besides a face's index and -1 for nothing: to be traced pixel by pixel.
constexpr std::int32_t kMixed = -2;

}  // namespace

/// A point of an edge on the plane at depth 1, and the inverse of its depth: both change linearly
/// along the edge's picture.
struct Visibility::Projected {
  float x;
  float y;
  float inverse_depth;

  [[nodiscard]] Projected towards(const Projected& other, float share) const {
    return {x + share * (other.x - x), y + share * (other.y - y),
            inverse_depth + share * (other.inverse_depth - inverse_depth)};
  }
};

Visibility::Visibility(std::shared_ptr<const Eye> eye)
    : eye_{std::move(eye)},
      block_cols_{(eye_->width_px + kBlock_px - 1) / kBlock_px},
      block_rows_{(eye_->height_px + kBlock_px - 1) / kBlock_px},
      cell_{kBlock_px * eye_->pixel_angle_x} {
  find_blocks_of_cells();
}

cv::Rect Visibility::pixels_of(std::size_t block) const {
  const int col = static_cast<int>(block) % block_cols_ * kBlock_px;
  const int row = static_cast<int>(block) / block_cols_ * kBlock_px;
  return {col, row, std::min(kBlock_px, eye_->width_px - col),
          std::min(kBlock_px, eye_->height_px - row)};
}

void Visibility::find_blocks_of_cells() {
  const float margin = kMargin_px * eye_->pixel_angle_x;
  const auto [min_x, max_x] = std::minmax_element(eye_->ray_x.begin(), eye_->ray_x.end());
  const auto [min_y, max_y] = std::minmax_element(eye_->ray_y.begin(), eye_->ray_y.end());
  left_ = *min_x - margin;
  top_ = *min_y - margin;
  cell_cols_ = static_cast<int>((*max_x + margin - left_) / cell_) + 1;
  cell_rows_ = static_cast<int>((*max_y + margin - top_) / cell_) + 1;
  std::vector<std::vector<std::uint32_t>> touched(
      static_cast<std::size_t>(cell_cols_ * cell_rows_));
  for (std::uint32_t block = 0; block < static_cast<std::uint32_t>(block_cols_ * block_rows_);
       ++block) {
    const cv::Rect pixels = pixels_of(block);
    Eigen::AlignedBox2f rays;
    for (int row = pixels.y; row < pixels.y + pixels.height; ++row) {
      for (int col = pixels.x; col < pixels.x + pixels.width; ++col) {
        rays.extend(eye_->ray(eye_->pixel(col, row)).head<2>());
      }
    }
    const auto cell = [this](float at, float begin, int cells) {
      return std::clamp(static_cast<int>((at - begin) / cell_), 0, cells - 1);
    };
    for (int y = cell(rays.min().y() - margin, top_, cell_rows_);
         y <= cell(rays.max().y() + margin, top_, cell_rows_); ++y) {
      for (int x = cell(rays.min().x() - margin, left_, cell_cols_);
           x <= cell(rays.max().x() + margin, left_, cell_cols_); ++x) {
        touched[static_cast<std::size_t>(y * cell_cols_ + x)].push_back(block);
      }
    }
  }
  for (const auto& blocks : touched) {
    first_of_cell_.push_back(static_cast<std::uint32_t>(blocks_of_cells_.size()));
    blocks_of_cells_.insert(blocks_of_cells_.end(), blocks.begin(), blocks.end());
  }
  first_of_cell_.push_back(static_cast<std::uint32_t>(blocks_of_cells_.size()));
}

cv::Mat_<std::int32_t> Visibility::look(const RayScene& scene, const Isometry& T_world_eye,
                                        std::span<const SeenFace> seen) const {
  std::vector<std::int32_t> blocks = look_at_corners(scene, T_world_eye);
  const Isometry T_eye_world = T_world_eye.inverse();
  for (const Edge& edge : scene.edges()) open_blocks_under(edge, T_eye_world, seen, blocks);
  cv::Mat_<std::int32_t> visible(eye_->height_px, eye_->width_px);
  for (std::size_t block = 0; block < blocks.size(); ++block) {
    if (blocks[block] == kMixed) {
      trace_block(block, scene, T_world_eye, visible);
    } else {
      const cv::Rect pixels = pixels_of(block);
      for (int row = pixels.y; row < pixels.y + pixels.height; ++row) {
        std::fill_n(visible[row] + pixels.x, pixels.width, blocks[block]);
      }
    }
  }
  return visible;
}

std::vector<std::int32_t> Visibility::look_at_corners(const RayScene& scene,
                                                      const Isometry& T_world_eye) const {
  const Eigen::Matrix3f R_world_eye = T_world_eye.linear().cast<float>();
  std::vector<Eigen::Vector3f> directions;
  for (int row = 0; row <= block_rows_; ++row) {
    for (int col = 0; col <= block_cols_; ++col) {
      directions.push_back(R_world_eye *
                           eye_->ray(eye_->pixel(std::min(col * kBlock_px, eye_->width_px - 1),
                                                 std::min(row * kBlock_px, eye_->height_px - 1))));
    }
  }
  std::vector<FaceIndex> corners(directions.size());
  scene.first_faces(T_world_eye.translation().cast<float>(), directions, corners);
  std::vector<std::int32_t> blocks;
  const auto stride = static_cast<std::size_t>(block_cols_) + 1;
  for (std::size_t row = 0; row < static_cast<std::size_t>(block_rows_); ++row) {
    for (std::size_t at = row * stride; at < row * stride + stride - 1; ++at) {
      const FaceIndex face = corners[at];
      const bool one = face == corners[at + 1] && face == corners[at + stride] &&
                       face == corners[at + stride + 1];
      blocks.push_back(one ? static_cast<std::int32_t>(face) : kMixed);
    }
  }
  return blocks;
}

void Visibility::open_blocks_under(const Edge& edge, const Isometry& T_eye_world,
                                   std::span<const SeenFace> seen,
                                   std::vector<std::int32_t>& blocks) const {
  Eigen::Vector3d a = T_eye_world * edge.from_m;
  Eigen::Vector3d b = T_eye_world * edge.to_m;
  if (a.z() < b.z()) std::swap(a, b);
  if (a.z() <= kNear_m) return;
  if (b.z() < kNear_m) b += (kNear_m - b.z()) / (a.z() - b.z()) * (a - b);
  const auto projected = [](const Eigen::Vector3d& p) {
    return Projected{static_cast<float>(p.x() / p.z()), static_cast<float>(p.y() / p.z()),
                     static_cast<float>(1 / p.z())};
  };
  // The part inside the cells' rectangle (Liang and Barsky 1984).
  const Projected from = projected(a);
  const Projected to = projected(b);
  float begin = 0;
  float end = 1;
  const auto clip = [&](float at, float way, float low, float high) {
    if (way == 0) {
      if (at < low || at > high) end = -1;
      return;
    }
    const float t0 = (low - at) / way;
    const float t1 = (high - at) / way;
    begin = std::max(begin, std::min(t0, t1));
    end = std::min(end, std::max(t0, t1));
  };
  clip(from.x, to.x - from.x, left_, left_ + cell_ * static_cast<float>(cell_cols_));
  clip(from.y, to.y - from.y, top_, top_ + cell_ * static_cast<float>(cell_rows_));
  if (begin > end) return;
  open_blocks_along(from.towards(to, begin), from.towards(to, end), seen, blocks);
}

void Visibility::open_blocks_along(const Projected& a, const Projected& b,
                                   std::span<const SeenFace> seen,
                                   std::vector<std::int32_t>& blocks) const {
  // From cell to cell (Amanatides and Woo 1987).
  const auto cell = [this](float at, float begin, int cells) {
    return std::clamp(static_cast<int>((at - begin) / cell_), 0, cells - 1);
  };
  int col = cell(a.x, left_, cell_cols_);
  int row = cell(a.y, top_, cell_rows_);
  const int last_col = cell(b.x, left_, cell_cols_);
  const int last_row = cell(b.y, top_, cell_rows_);
  const int step_col = b.x < a.x ? -1 : 1;
  const int step_row = b.y < a.y ? -1 : 1;
  const auto next = [this](float at, float way, float begin, int index, int step) {
    const float border = begin + cell_ * static_cast<float>(step > 0 ? index + 1 : index);
    return way == 0 ? std::numeric_limits<float>::infinity() : (border - at) / way;
  };
  float entered = 0;
  for (int steps = cell_cols_ + cell_rows_ + 2; steps > 0; --steps) {
    const float next_col = next(a.x, b.x - a.x, left_, col, step_col);
    const float next_row = next(a.y, b.y - a.y, top_, row, step_row);
    const float left_at = std::clamp(std::min(next_col, next_row), entered, 1.0F);
    const Projected in = a.towards(b, entered);
    const Projected out = a.towards(b, left_at);
    const auto index = static_cast<std::size_t>(row * cell_cols_ + col);
    for (std::uint32_t i = first_of_cell_[index]; i < first_of_cell_[index + 1]; ++i) {
      std::int32_t& block = blocks[blocks_of_cells_[i]];
      if (block == kMixed) continue;
      if (block >= 0) {
        const SeenFace& face = seen[static_cast<std::size_t>(block)];
        const auto hidden = [&face](const Projected& point) {
          return point.inverse_depth < (1 - kTolerance) * face.inverse_depth_at(point.x, point.y);
        };
        if (hidden(in) && hidden(out)) continue;
      }
      block = kMixed;
    }
    if (left_at >= 1 || (col == last_col && row == last_row)) return;
    entered = left_at;
    (next_col < next_row ? col : row) += next_col < next_row ? step_col : step_row;
    if (col < 0 || col >= cell_cols_ || row < 0 || row >= cell_rows_) return;
  }
}

void Visibility::trace_block(std::size_t block, const RayScene& scene, const Isometry& T_world_eye,
                             cv::Mat_<std::int32_t>& visible) const {
  const Eigen::Matrix3f R_world_eye = T_world_eye.linear().cast<float>();
  const cv::Rect pixels = pixels_of(block);
  std::array<Eigen::Vector3f, kBlock_px * kBlock_px> directions;
  std::array<FaceIndex, kBlock_px * kBlock_px> found;
  std::size_t count = 0;
  for (int row = pixels.y; row < pixels.y + pixels.height; ++row) {
    for (int col = pixels.x; col < pixels.x + pixels.width; ++col) {
      directions[count++] = R_world_eye * eye_->ray(eye_->pixel(col, row));
    }
  }
  scene.first_faces(T_world_eye.translation().cast<float>(), {directions.data(), count},
                    {found.data(), count});
  count = 0;
  for (int row = pixels.y; row < pixels.y + pixels.height; ++row) {
    for (int col = pixels.x; col < pixels.x + pixels.width; ++col) {
      visible(row, col) = static_cast<std::int32_t>(found[count++]);
    }
  }
}

}  // namespace cairn::simulation
