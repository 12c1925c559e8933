// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <random>
#include <span>

#include "camera/rig_calibration.hpp"
#include "simulation/depth_renderer.hpp"
#include "simulation/world.hpp"
#include "stereo/disparity_image.hpp"

namespace cairn::testing {

/// What is wrong with the bench's stereo.
struct EyeTrouble {
  double noise_px = 0.3;    ///< one sigma, of disparity, at full size
  double bleed = 0.3;       ///< share of answers taken from the grid's neighbour left or right
  double drop_out = 0.05;   ///< share of answers missing
  double nearest_m = 0.73;  ///< nearer than that nothing is matched
};

/// The simulated robot's cameras on its body: 60 degrees wide, level, 0.30 m high, 25.4 cm apart.
[[nodiscard]] camera::RigCalibration bench_rig();

/// True depth as the disparities that a matcher would send: with noise, edges that bleed, drop-outs,
/// and no answer where it is too near or the right camera sees nothing.
class BenchEyes {
 public:
  BenchEyes(const simulation::World& world, int step_px, const EyeTrouble& trouble, unsigned seed);

  [[nodiscard]] stereo::DisparityImage look(const Isometry& T_world_body, Utime utime,
                                            std::span<const simulation::PersonPose> people);
  /// The world has become another.
  void see(const simulation::World& world);

 private:
  camera::RigCalibration rig_;
  int step_px_;
  EyeTrouble trouble_;
  std::unique_ptr<simulation::DepthRenderer> renderer_;
  std::mt19937 random_;
};

}  // namespace cairn::testing
