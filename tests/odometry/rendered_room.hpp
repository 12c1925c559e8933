// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>

#include "core/geometry.hpp"
#include "stereo/disparity_image.hpp"

namespace cairn::testing {

/// An upright board, papered like the room: it faces along its own x axis, its middle is its
/// origin, y to the left and z up.
struct Panel {
  Isometry T_room_panel = Isometry::Identity();
  double width_m = 1;
  double height_m = 1;
};

/// A box room of 6 x 5 x 2.5 m, x and y from its middle, z from its floor, papered with smooth
/// noise: what a camera sees there, ray by ray, with a known pose and no approximation but the 2x2
/// samples per pixel.
class RenderedRoom {
 public:
  /// The left or right image of a rectified rig whose body is at T_room_body; a panel may stand in
  /// the room.
  [[nodiscard]] static cv::Mat left(const stereo::RectifiedCamera& camera,
                                    const Isometry& T_room_body, const Panel* panel = nullptr);
  [[nodiscard]] static cv::Mat right(const stereo::RectifiedCamera& camera,
                                     const Isometry& T_room_body, const Panel* panel = nullptr);
};

/// 640 x 480, 60 degrees wide, 0.254 m apart, 0.3 m above the floor, tilted down by 5 degrees.
[[nodiscard]] stereo::RectifiedCamera robot_camera();

/// Adds Gaussian noise, the same for the same seed.
[[nodiscard]] cv::Mat with_noise(const cv::Mat& image, double sigma, std::uint64_t seed);

}  // namespace cairn::testing
