// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "core/config.hpp"
#include "core/geometry.hpp"
#include "core/result.hpp"
#include "mapping/grid_index.hpp"
#include "mapping/voxel_map.hpp"
#include "stereo/disparity_image.hpp"

namespace cairn::mapping {

struct RayIntegratorConfig {
  double min_range_m = 0.2;
  double max_range_m = 4.0;
  int min_confidence = 1;
  int hit_evidence = 4;
  int miss_evidence = 2;

  void visit(ConfigVisitor& v) {
    v.number("min_range_m", min_range_m, {0, 10}, "m", "nearer measurements are ignored");
    v.number("max_range_m", max_range_m, {0.1, 200}, "m",
             "a farther measurement frees the way up to here and gives no hit");
    v.integer("min_confidence", min_confidence, 0, 3, "code",
              "pixels of a lower confidence are ignored");
    v.integer("hit_evidence", hit_evidence, 1, 255, "evidence",
              "added once per frame to a voxel that a ray ends in");
    v.integer("miss_evidence", miss_evidence, 1, 255, "evidence",
              "added once per frame to a voxel that rays only pass through");
  }
};

struct Integration {
  std::size_t rays = 0;             ///< pixels used
  std::size_t hits = 0;             ///< of them, those that ended within the range
  std::size_t voxels = 0;           ///< that got evidence
  std::vector<BrickIndex> changed;  ///< bricks in which a voxel changed its class, sorted
};

/// Adds depth images to a map. Each used pixel is a ray from the camera to the measured point; a
/// voxel gets at most one hit or one miss per frame, and a hit wins. Pixels with no answer say
/// nothing. The order of pixels does not matter to the outcome.
class Integrator {
 public:
  virtual ~Integrator() = default;

  /// An error leaves the map as it was: an image whose planes differ in size, a camera or pose that
  /// is not finite, a pose outside the map's limits.
  [[nodiscard]] virtual Result<Integration> integrate(const stereo::DisparityImage& image,
                                                      const Isometry& T_map_camera,
                                                      VoxelMap& map) = 0;
};

/// Whether an image can be integrated from here: Integrator::integrate's errors.
[[nodiscard]] Result<void> check_integrable(const stereo::DisparityImage& image,
                                            const Isometry& T_map_camera, const VoxelMap& map,
                                            double max_range_m);

}  // namespace cairn::mapping
