// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/geometry.hpp"
#include "odometry/motion.hpp"
#include "stereo/disparity_image.hpp"

namespace cairn::odometry {

/// A pixel of a left image together with its disparity to a right camera of the same cx (that is,
/// disparity + doffs).
struct StereoPixel {
  double u_px = 0;
  double v_px = 0;
  double disparity_px = 0;  ///< positive: depth = f * baseline / disparity
};

/// The same point of the scene from two places.
struct PointPair {
  StereoPixel anchor;          ///< as the reference place saw it
  double anchor_sigma_px = 0;  ///< of the anchor's disparity; its u, v count as exact
  StereoPixel seen;            ///< as the new place sees it
};

/// How well pixels are measured at the new place.
struct PixelNoise {
  double position_sigma_px = 0.3;
  double disparity_sigma_px = 0.2;
};

struct StereoPose {
  Isometry T_new_anchor = Isometry::Identity();
  /// Of a small motion of the new camera, in its own frame [m, rad], scaled by the residuals found.
  Matrix6d covariance = Matrix6d::Zero();
  std::vector<bool> is_inlier;  ///< per pair
  int inliers = 0;
};

[[nodiscard]] Eigen::Vector3d to_point(const StereoPixel& pixel,
                                       const stereo::RectifiedCamera& camera);
[[nodiscard]] StereoPixel to_pixel(const Eigen::Vector3d& point,
                                   const stereo::RectifiedCamera& camera);

/// Where the new place is, from point pairs with wrong ones among them: the smallest truncated cost
/// over the guess, refined over all pairs, and over poses fitted to random triples (RANSAC as in
/// Geiger, Ziegler and Stiller 2011), then Gauss-Newton with Huber weights over what fits. A
/// residual is (u, v, disparity) at the new place, weighted by its noise and by what the anchor's
/// disparity noise makes of it there. Nothing if fewer than `min_inliers` agree or they leave the
/// pose open. The same arguments give the same result.
[[nodiscard]] std::optional<StereoPose> solve_stereo_pose(const std::vector<PointPair>& pairs,
                                                          const stereo::RectifiedCamera& camera,
                                                          const PixelNoise& noise,
                                                          const Isometry& guess_T_new_anchor,
                                                          int min_inliers, std::uint32_t seed);

}  // namespace cairn::odometry
