// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <vector>

#include "camera/rig_calibration.hpp"
#include "core/robot.hpp"
#include "planning/clearance.hpp"
#include "simulation/renderer.hpp"
#include "simulation/world.hpp"
#include "stereo/matcher.hpp"
#include "stereo/rectifier.hpp"

namespace cairn::testing {

/// Where the disparities come from.
enum class Sight { kTrueDepth, kStereo };

/// The robot of config/robots/simulated.yaml as far as seeing goes: cameras 0.30 m high, level,
/// over the body's middle, undistorted.
[[nodiscard]] camera::RigCalibration level_rig();

/// What that robot sees in a world: disparities as stereo sends them, either out of the rendered
/// pair, or out of the true depth, without noise but cut where no stereo could answer (nearer than
/// its range; beyond the right image).
class Eyes {
 public:
  Eyes(const simulation::World& world, Sight sight);
  [[nodiscard]] stereo::DisparityImage look(const Isometry& T_world_body, std::int64_t frame,
                                            Utime utime);

 private:
  camera::RigCalibration rig_;
  Sight sight_;
  std::unique_ptr<simulation::Renderer> renderer_;
  std::unique_ptr<stereo::Rectifier> rectifier_;
  std::unique_ptr<stereo::Matcher> matcher_;
};

/// True if the body at this pose, z = 0 on a level floor, touches something from 3.5 cm on, or
/// stands with a part of it where no floor is. Points 2 cm apart.
[[nodiscard]] bool in_trouble(const simulation::World& world, const RobotConfig& robot,
                              const Eigen::Isometry2d& T_world_body);

/// True if the robot, going straight on at this speed until the reaction time is over and then
/// braking, gets into trouble.
[[nodiscard]] bool ends_in_trouble(const simulation::World& world, const RobotConfig& robot,
                                   const Eigen::Isometry2d& T_world_body, double speed_mps,
                                   double reaction_s);

struct DriveLog {
  std::vector<planning::Permission> allowed;  ///< one a frame
  std::vector<double> forward_m;              ///< way so far, one a frame
  int unsafe = 0;                             ///< frames whose permission ends in trouble
  bool trouble = false;
};

/// Drives straight on, at what is allowed and at `wanted_mps` at most, 15 frames a second, and
/// holds each permission against the truth.
[[nodiscard]] DriveLog drive_on(const simulation::World& world, Eyes& eyes,
                                const Eigen::Isometry2d& T_world_start, double wanted_mps,
                                int frames);

}  // namespace cairn::testing
