// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/config.hpp"
#include "core/geometry.hpp"
#include "localization/distance_field.hpp"
#include "localization/map_provenance.hpp"
#include "localization/pose_belief.hpp"
#include "localization/pose_change.hpp"
#include "localization/surface.hpp"
#include "localization/view.hpp"
#include "mapping/map_replica.hpp"

namespace cairn::localization {

/// The map, as localisation looks at it. All of it must outlive this.
struct MapView {
  const mapping::MapReplica& map;
  const DistanceField& field;
  Surfaces& surfaces;
};

/// How well a view fits the map from a pose.
struct Fit {
  int known = 0;  ///< beams that end where the map knows something
  int hits = 0;   ///< of them, those that end at a surface
  /// The same for beams that end well over the body's floor: floor looks the same everywhere.
  int standing_known = 0;
  int standing_hits = 0;
  double cost = 0;  ///< mean over the known ones, 0 (all fit) to 1 (none does)
};

struct Refinement {
  PoseBelief pose;     ///< what is known with the view; what was known without, if it did not fit
  Fit before;          ///< where it began
  Fit after;           ///< where it came to
  int points = 0;      ///< that lie near a surface
  int directions = 0;  ///< of the six of a pose, those that the points determine
  bool improved = false;  ///< else nothing was learned
};

struct RefinementConfig {
  int iterations = 15;
  int min_points = 40;
  double reach_m = 0.3;
  double observed_sigma_m = 0.03;
  double map_sigma_m = 0.02;
  double map_sigma_rad = 0.01;

  void visit(ConfigVisitor& v) {
    v.integer("iterations", iterations, 1, 50, "", "steps at most");
    v.integer("min_points", min_points, 10, 2000, "", "fewer points near a surface move nothing");
    v.number("reach_m", reach_m, {0.02, 0.5}, "m", "how far from its surface a point may begin");
    v.number("observed_sigma_m", observed_sigma_m, {0.001, 1}, "m",
             "directions that the points, if each erred alone, would determine worse than this are "
             "left alone");
    v.number(
        "map_sigma_m", map_sigma_m, {0.001, 1}, "m",
        "how far the map may be off, the same from frame to frame (one sigma), if not a voxel");
    v.number("map_sigma_rad", map_sigma_rad, {0.0005, 0.5}, "rad", "likewise turned");
  }
};

/// Joins what is known of a pose with how the view fits the map: the pose is moved to where both
/// agree best (Kalman's update, iterated: Bell and Cathey 1993), and its covariance shrinks.
///
/// The view's part is Gauss-Newton over the points' distances from the surfaces that the distance
/// field leads to, each weighted by its noise across the surface (in disparity the same for all),
/// with the kernel of Geman and McClure (1985) that tightens from step to step (graduated
/// non-convexity, Blake and Zisserman 1987). Directions that no points determine, along a corridor
/// say, are left to what was known: a direction counts as determined by the points whose surfaces
/// face it, not by what the others' rough normals seem to say (localizability: Tuna et al. 2022,
/// X-ICP). What is determined is yet off by what the map is, frame after frame the same.
///
/// `authority` is what the map there can say. That the map is off the same way from frame to frame
/// is considered and not estimated (Schmidt 1966): seen again it is no news.
[[nodiscard]] Refinement refine(const MapView& map, const View& view, const PoseBelief& known,
                                const MapAuthority& authority, const RefinementConfig& config);

/// How well the view fits from there.
[[nodiscard]] Fit fit_of(const DistanceField& field, const View& view, const Isometry& T_map_body);

}  // namespace cairn::localization
