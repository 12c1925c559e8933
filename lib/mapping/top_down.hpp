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
  std::optional<Isometry> T_map_body;           ///< the last pose; an arrow along its x axis
};

struct TopDownConfig {
  double min_height_m = -std::numeric_limits<double>::infinity();  ///< what lies lower is left out
  double max_height_m = std::numeric_limits<double>::infinity();   ///< what lies higher is left out
  int size_px = 1000;  ///< about the longer side; from 100 to 8000
};

/// The map seen from above (BGR): x to the right, y up. Occupied columns are the darker the more of
/// them is occupied, coloured by the height of their top; free is near white, unknown grey. Cut to
/// what is occupied and driven, but for the outermost stray voxels. With a scale bar. A map with
/// nothing known gives a grey picture.
[[nodiscard]] cv::Mat render_top_down(const VoxelMap& map, const TopDownOverlay& overlay = {},
                                      const TopDownConfig& config = {});

}  // namespace cairn::mapping
