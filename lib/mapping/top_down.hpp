// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "core/geometry.hpp"
#include "mapping/voxel_map.hpp"

namespace cairn::mapping {

/// What is drawn over the map; all optional.
struct TopDownOverlay {
  std::vector<Eigen::Vector3d> true_path;       ///< positions in the map frame [m]; green
  std::vector<Eigen::Vector3d> perceived_path;  ///< blue
  std::optional<Isometry> T_map_true_body;      ///< where it truly is: a green arrow along x
  std::optional<Isometry> T_map_body;           ///< where it takes itself to be: a blue one
};

struct TopDownConfig {
  double min_height_m = -std::numeric_limits<double>::infinity();  ///< what lies lower is left out
  double max_height_m = std::numeric_limits<double>::infinity();   ///< what lies higher is left out
  int size_px = 1000;  ///< about the longer side; from 100 to 8000
};

/// The map seen from above (BGR), x to the right, y up, in the manner of the paper's figure 7: a
/// pixel is filled where a block is, over all heights. Colour is the height of the topmost block,
/// strength how many there are; ground and what is as flat is pale, free is white, unknown grey.
/// Cut to what is occupied and driven, but for the outermost stray voxels. Below it a scale bar and
/// what the colours stand for. A map with nothing known gives a grey picture.
[[nodiscard]] cv::Mat render_top_down(const VoxelMap& map, const TopDownOverlay& overlay = {},
                                      const TopDownConfig& config = {});

}  // namespace cairn::mapping
