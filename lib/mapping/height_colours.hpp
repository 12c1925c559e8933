// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/core.hpp>

namespace cairn::mapping {

/// Colour (BGR) of a height: 0 lowest, 1 highest; outside it the nearer end. Dark violet through
/// red to amber, so that green and blue stay free for what is drawn on top.
[[nodiscard]] inline cv::Vec3b height_colour(double height) {
  static constexpr std::array<std::array<double, 3>, 5> kStops{
      {{72, 30, 40}, {120, 36, 104}, {84, 52, 188}, {44, 116, 232}, {60, 182, 250}}};
  const double at = std::clamp(height, 0.0, 1.0) * (kStops.size() - 1);
  const std::size_t below = std::min(static_cast<std::size_t>(at), kStops.size() - 2);
  const double share = at - static_cast<double>(below);
  cv::Vec3b colour;
  for (std::size_t i = 0; i < 3; ++i) {
    colour[static_cast<int>(i)] = cv::saturate_cast<std::uint8_t>(kStops[below][i] * (1 - share) +
                                                                  kStops[below + 1][i] * share);
  }
  return colour;
}

}  // namespace cairn::mapping
