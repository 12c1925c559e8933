// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <opencv2/core.hpp>
#include <span>

#include "camera/rig_calibration.hpp"
#include "core/geometry.hpp"
#include "core/result.hpp"
#include "simulation/person_pose.hpp"
#include "simulation/sensor.hpp"
#include "simulation/world.hpp"

namespace cairn::simulation {

/// A pair as the rig would have taken it, and what is true.
struct RenderedPair {
  cv::Mat_<std::uint8_t> left;
  cv::Mat_<std::uint8_t> right;
  cv::Mat_<float>
      left_depth_m;  ///< along the optical axis, of each pixel's centre; 0 = nothing there
};

/// Renders what a rig sees in a world: bitmap textures, lit once when the renderer is made; pixels
/// on the borders of faces are averaged over four rays. The lens bends as the calibration says.
/// What surfaces look like is the world's alone; the seed chooses the noise and how the exposure
/// wanders. The same arguments give the same bytes.
class Renderer {
 public:
  [[nodiscard]] static Result<Renderer> create(const World& world,
                                               const camera::RigCalibration& rig,
                                               const SensorConfig& sensor, std::uint64_t seed);
  ~Renderer();
  Renderer(Renderer&&) noexcept;
  Renderer& operator=(Renderer&&) noexcept;

  /// Every `frame` number has a noise and an exposure of its own. People that the world does not
  /// have are left out.
  [[nodiscard]] RenderedPair render(const Isometry& T_world_body, std::int64_t frame,
                                    std::span<const PersonPose> people = {}) const;

  /// True depth alone, as left_depth_m above, at every `step`-th pixel of every `step`-th row from
  /// the first ones on; of the right camera in its own frame.
  [[nodiscard]] cv::Mat_<float> left_depth_m(const Isometry& T_world_body, int step = 1,
                                             std::span<const PersonPose> people = {}) const;
  [[nodiscard]] cv::Mat_<float> right_depth_m(const Isometry& T_world_body, int step = 1,
                                              std::span<const PersonPose> people = {}) const;

  /// Exposure of both cameras in a frame over that of frame 0.
  [[nodiscard]] double exposure(std::int64_t frame) const;

 private:
  struct State;
  explicit Renderer(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace cairn::simulation
