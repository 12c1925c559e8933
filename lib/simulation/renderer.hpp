// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <opencv2/core.hpp>

#include "camera/rig_calibration.hpp"
#include "core/config.hpp"
#include "core/geometry.hpp"
#include "core/result.hpp"
#include "simulation/world.hpp"

namespace cairn::simulation {

/// How the two sensors differ from perfect ones and from each other.
struct SensorConfig {
  double read_noise_grey = 1.5;
  double shot_noise_grey = 0.02;
  double right_gain = 1.06;
  double right_offset_grey = 2;

  void visit(ConfigVisitor& v) {
    v.number("read_noise_grey", read_noise_grey, {0, 50}, "grey",
             "standard deviation of the noise of a black pixel");
    v.number("shot_noise_grey", shot_noise_grey, {0, 10}, "grey",
             "variance that the noise gains per grey level");
    v.number("right_gain", right_gain, {0.2, 5}, "",
             "exposure of the right camera over the left's");
    v.number("right_offset_grey", right_offset_grey, {-100, 100}, "grey",
             "black level of the right camera less the left's");
  }
};

/// A pair as the rig would have taken it, and what is true.
struct RenderedPair {
  cv::Mat_<std::uint8_t> left;
  cv::Mat_<std::uint8_t> right;
  cv::Mat_<float>
      left_depth_m;  ///< along the optical axis, of each pixel's centre; 0 = nothing there
};

/// Renders what a rig sees in a world: bitmap textures, lit once when the renderer is made; pixels
/// on the edges of faces are averaged over four rays. The lens bends as the calibration says. What
/// surfaces look like is the world's alone; the seed chooses the noise. The same arguments give the
/// same bytes.
class Renderer {
 public:
  [[nodiscard]] static Result<Renderer> create(const World& world,
                                               const camera::RigCalibration& rig,
                                               const SensorConfig& sensor, std::uint64_t seed);
  ~Renderer();
  Renderer(Renderer&&) noexcept;
  Renderer& operator=(Renderer&&) noexcept;

  /// Every `frame` number has a noise of its own.
  [[nodiscard]] RenderedPair render(const Isometry& T_world_body, std::int64_t frame) const;

  /// True depth alone, as left_depth_m above; of the right camera in its own frame.
  [[nodiscard]] cv::Mat_<float> left_depth_m(const Isometry& T_world_body) const;
  [[nodiscard]] cv::Mat_<float> right_depth_m(const Isometry& T_world_body) const;

 private:
  struct State;
  explicit Renderer(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace cairn::simulation
