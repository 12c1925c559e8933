// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <opencv2/core.hpp>
#include <span>

#include "camera/rig_calibration.hpp"
#include "core/geometry.hpp"
#include "core/result.hpp"
#include "simulation/person_pose.hpp"
#include "simulation/world.hpp"

namespace cairn::simulation {

/// True depth as a rig's cameras see it, without pictures: made at once, where a Renderer first
/// paints all surfaces. Gives the same depth as a Renderer.
class DepthRenderer {
 public:
  [[nodiscard]] static Result<DepthRenderer> create(const World& world,
                                                    const camera::RigCalibration& rig);
  ~DepthRenderer();
  DepthRenderer(DepthRenderer&&) noexcept;
  DepthRenderer& operator=(DepthRenderer&&) noexcept;

  /// Along the optical axis [m], of the centre of every `step`-th pixel of every `step`-th row from
  /// the first ones on; 0 where nothing is. Of the right camera in its own frame.
  [[nodiscard]] cv::Mat_<float> left_m(const Isometry& T_world_body, int step,
                                       std::span<const PersonPose> people = {}) const;
  [[nodiscard]] cv::Mat_<float> right_m(const Isometry& T_world_body, int step,
                                        std::span<const PersonPose> people = {}) const;

 private:
  struct State;
  explicit DepthRenderer(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace cairn::simulation
