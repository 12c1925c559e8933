// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <span>
#include <vector>

#include "simulation/face.hpp"
#include "simulation/world.hpp"

namespace cairn::simulation {

/// The picture on a face, lit: grey values 0 to 255, in halving sizes (Williams 1983).
struct FaceTexture {
  /// Texels that repeat the border on every side, so that a spot near it needs no special care.
  static constexpr int kPad = 6;

  struct Level {
    cv::Mat_<std::uint8_t> grey;  ///< padded
    float texels_per_m;
  };
  std::vector<Level> levels;  ///< from the finest to a single texel

  /// A spot on the face that a pixel sees: an ellipse with this width, and this length along the
  /// direction (along_s, along_t), which has unit length.
  struct Spot {
    float minor_m;
    float major_m;
    float along_s;
    float along_t;
  };

  /// Mean grey values of such spots around each (s, t) [m]; at most kMaxRun at once.
  static constexpr std::size_t kMaxRun = 16;
  void sample(std::span<const float> s_m, std::span<const float> t_m, const Spot& spot,
              float* grey) const;
};

/// Bakes the picture of a face from its material. The same arguments give the same bytes.
[[nodiscard]] FaceTexture bake_texture(const World& world, const Face& face,
                                       const Material& material, std::uint64_t seed);

}  // namespace cairn::simulation
