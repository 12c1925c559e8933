// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <opencv2/core.hpp>
#include <span>
#include <vector>

#include "core/geometry.hpp"
#include "simulation/eye.hpp"
#include "simulation/ray_scene.hpp"
#include "simulation/seen_face.hpp"

namespace cairn::simulation {

/// Finds which face each pixel of an eye sees, as if each had a ray of its own, but with few rays:
/// a block of pixels whose four corners see the same face, and in which no edge of a box lies
/// before that face, sees nothing else. (What stands before a face is bounded by its edges and by
/// the straight line in which it cuts the face; behind such a line without an edge there is always
/// a corner of the block.)
class Visibility {
 public:
  explicit Visibility(std::shared_ptr<const Eye> eye);

  /// Index of the face of each pixel, -1 where nothing is. `seen` are the scene's faces from there.
  [[nodiscard]] cv::Mat_<std::int32_t> look(const RayScene& scene, const Isometry& T_world_eye,
                                            std::span<const SeenFace> seen) const;

 private:
  struct Projected;
  void find_blocks_of_cells();
  [[nodiscard]] std::vector<std::int32_t> look_at_corners(const RayScene& scene,
                                                          const Isometry& T_world_eye) const;
  void open_blocks_under(const Edge& edge, const Isometry& T_world_eye,
                         std::span<const SeenFace> seen, std::vector<std::int32_t>& blocks) const;
  void open_blocks_along(const Projected& a, const Projected& b, std::span<const SeenFace> seen,
                         std::vector<std::int32_t>& blocks) const;
  void trace_block(std::size_t block, const RayScene& scene, const Isometry& T_world_eye,
                   cv::Mat_<std::int32_t>& visible) const;
  [[nodiscard]] cv::Rect pixels_of(std::size_t block) const;

  std::shared_ptr<const Eye> eye_;
  int block_cols_;
  int block_rows_;
  // Square cells over the plane at depth 1, where edges are straight: which blocks each touches.
  float cell_;
  float left_;
  float top_;
  int cell_cols_;
  int cell_rows_;
  std::vector<std::uint32_t> first_of_cell_;
  std::vector<std::uint32_t> blocks_of_cells_;
};

}  // namespace cairn::simulation
