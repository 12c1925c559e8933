// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/geometry.hpp"
#include "core/robot.hpp"
#include "simulation/contact.hpp"
#include "simulation/ground.hpp"
#include "simulation/person_pose.hpp"
#include "simulation/world.hpp"

namespace cairn::simulation {

/// Tracks climb a step up to this; a higher one is a wall to the body.
inline constexpr double kClimb_m = 0.0201;

/// The robot as a solid: a box on two tracks. What the tracks can climb passes under the box.
class BodyShape {
 public:
  explicit BodyShape(const RobotConfig& robot);

  [[nodiscard]] const TrackPlan& tracks() const { return tracks_; }
  /// Round the body frame's origin, in plan, whatever the stance [m].
  [[nodiscard]] double reach_m() const { return reach_m_; }

  [[nodiscard]] Contact with_box(const Isometry& T_world_body, const Box& box) const;
  /// With what can be seen of somebody: at the body's height their legs, not the circle that holds
  /// them.
  [[nodiscard]] Contact with_person(const Isometry& T_world_body, const Person& person,
                                    const PersonPose& pose) const;

 private:
  TrackPlan tracks_;
  Eigen::Vector3d half_m_;
  double middle_height_m_;
  double reach_m_;
};

}  // namespace cairn::simulation
