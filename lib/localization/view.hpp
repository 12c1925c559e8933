// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "core/config.hpp"
#include "core/geometry.hpp"
#include "stereo/disparity_image.hpp"

namespace cairn::localization {

/// One measured point, in the body frame.
struct Beam {
  Eigen::Vector3d point_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d along = Eigen::Vector3d::Zero();  ///< from the camera to it, of length 1
  double range_m = 0;                               ///< from the camera
  double sigma_m = 0;  ///< of the range, by the disparity's noise: it grows with its square
};

/// What was seen in one frame, thinned out.
struct View {
  Utime utime = 0;
  Eigen::Vector3d eye_m = Eigen::Vector3d::Zero();  ///< the camera, in the body frame
  std::vector<Beam> beams;                          ///< in no order that matters
};

struct ViewConfig {
  int points = 400;
  int min_confidence = 2;
  double min_range_m = 0.3;
  double max_range_m = 6;
  double disparity_sigma_px = 0.5;

  void visit(ConfigVisitor& v) {
    v.integer("points", points, 50, 5000, "", "how many points of a frame to use, at most");
    v.integer("min_confidence", min_confidence, 0, 3, "code",
              "pixels of a lower confidence are not used");
    v.number("min_range_m", min_range_m, {0, 10}, "m", "nearer measurements are not used");
    v.number("max_range_m", max_range_m, {0.5, 200}, "m", "nor farther ones");
    v.number("disparity_sigma_px", disparity_sigma_px, {0.05, 5}, "px",
             "standard deviation of a sure disparity, in pixels of the full image");
  }
};

/// Takes one point from each of as many fields of the image as there are to be points: a sure one
/// that does not lie on an edge. Which one, `seed` and the frame's utime decide.
[[nodiscard]] View make_view(const stereo::DisparityImage& image, const ViewConfig& config,
                             std::uint64_t seed);

}  // namespace cairn::localization
