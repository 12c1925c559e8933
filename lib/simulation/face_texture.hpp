// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "simulation/face.hpp"
#include "simulation/world.hpp"

namespace cairn::simulation {

/// The picture on a face, lit: grey values 0 to 255, in halving sizes (Williams 1983).
struct FaceTexture {
  struct Level {
    cv::Mat_<std::uint8_t> grey;
    float texels_per_m;
  };
  std::vector<Level> levels;  ///< from the finest to a single texel

  /// Mean grey value around (s, t) [m] of a spot `minor_m` wide and `major_m` long along the
  /// direction (along_s, along_t), which has unit length.
  [[nodiscard]] float sample(float s_m, float t_m, float minor_m, float major_m, float along_s,
                             float along_t) const;
};

/// Bakes the picture of a face from its material. The same arguments give the same bytes.
[[nodiscard]] FaceTexture bake_texture(const World& world, const Face& face,
                                       const Material& material, std::uint64_t seed);

}  // namespace cairn::simulation
