// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <span>
#include <vector>

#include "core/geometry.hpp"
#include "core/result.hpp"
#include "core/time.hpp"
#include "simulation/depth_renderer.hpp"
#include "simulation/person_pose.hpp"
#include "simulation/world.hpp"
#include "stereo/disparity_image.hpp"

namespace cairn::simulation {

/// Disparities as the matcher of the shipped robot would have found them, without pictures: true
/// depth through a model of its noise, bias, drop-out, edge bleed and confidence, on every fourth
/// pixel. The numbers were measured on the four textured worlds (procs/simulator/README.md); plain
/// surfaces drop out no more than others here. About half of an error, and most of what drops out,
/// belongs to the surface and stays with it from frame to frame; the rest is new in each frame. The
/// same arguments give the same bytes.
class DisparityModel {
 public:
  static constexpr int kStep_px = 4;
  /// Disparities from this on are nearer than the matcher looks (it searches to below 192, and
  /// takes the last one searched for no answer).
  static constexpr double kEnd_px = 190;

  [[nodiscard]] static Result<DisparityModel> create(const World& world,
                                                     const camera::RigCalibration& rig,
                                                     std::uint64_t seed);

  [[nodiscard]] stereo::DisparityImage see(const Isometry& T_world_body, std::int64_t frame,
                                           Utime utime, std::span<const PersonPose> people) const;

 private:
  DisparityModel(DepthRenderer depth, stereo::RectifiedCamera camera, std::uint64_t seed)
      : depth_{std::move(depth)}, camera_{std::move(camera)}, seed_{seed} {}

  DepthRenderer depth_;
  stereo::RectifiedCamera camera_;
  std::uint64_t seed_;
};

}  // namespace cairn::simulation
