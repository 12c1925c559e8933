// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <random>
#include <vector>

#include "core/robot.hpp"
#include "planning/cell_grid.hpp"
#include "planning/pose2.hpp"
#include "simulation/world.hpp"
#include "stereo/disparity_image.hpp"

namespace cairn::testing {

/// A stereo camera as the simulated robot's, but coarse: 60 degrees wide, 0.30 m high, level.
[[nodiscard]] stereo::RectifiedCamera coarse_camera(int width_px, int height_px);

/// What that camera measures in a world of boxes, by the slab method (Kay and Kajiya 1986): true
/// depth as disparity with normal noise of 0.3 px at 640 pixels of width; no answer nearer than
/// 0.73 m, nor where the right camera sees nothing.
class BenchEyes {
 public:
  BenchEyes(const std::vector<simulation::Box>& boxes, const stereo::RectifiedCamera& camera,
            unsigned seed)
      : boxes_{boxes}, camera_{camera}, random_{seed} {}

  [[nodiscard]] stereo::DisparityImage look(const Isometry& T_world_body, Utime utime);

 private:
  const std::vector<simulation::Box>& boxes_;
  stereo::RectifiedCamera camera_;
  std::mt19937 random_;
};

/// True if the body at this pose, its floor at z, overlaps a box that is over 3 cm above that.
[[nodiscard]] bool touches(const std::vector<simulation::Box>& boxes, const RobotConfig& robot,
                           const Isometry& T_world_body);

/// Floor at z = 0 that the robot's turning circle can cover, coming from `start`; as cells of the
/// world frame.
[[nodiscard]] planning::CellGrid<std::uint8_t> reachable_floor(
    const std::vector<simulation::Box>& boxes, const RobotConfig& robot,
    const Eigen::Vector2d& start_m);

}  // namespace cairn::testing
