// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "camera/rig_calibration.hpp"
#include "core/result.hpp"
#include "simulation/world.hpp"

namespace cairn::simulation {

/// What counts as too little texture for stereo: where the mean square of the horizontal gradient
/// (central difference) over a square block of the noise-free image is below a threshold (the
/// measure of Scharstein and Szeliski 2002, section 5, with a matcher's block). With noise of
/// deviation s in both images the disparity of an n x n block is uncertain by at least
/// s sqrt(2 / sum of squared gradients) (the Cramer-Rao bound): for s = 2.1 grey, n = 11 and the
/// threshold of 1 grey^2 that is 0.27 px.
struct TextureConfig {
  int places = 20;  ///< free places on the reachable floor
  std::uint64_t seed = 1;
  int directions = 6;         ///< at each place, evenly all round
  double min_depth_m = 0.73;  ///< what is nearer is out of stereo's range and does not count
  int block_px = 11;
  double least_gradient_grey2 = 1;
};

/// Share of what the rig's left camera sees of the world that has too little texture, in [0, 1].
[[nodiscard]] Result<double> textureless_share(const World& world,
                                               const camera::RigCalibration& rig,
                                               const TextureConfig& config);

}  // namespace cairn::simulation
