// SPDX-License-Identifier: Apache-2.0
#include "simulation/body_shape.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "simulation/person_look.hpp"

namespace cairn::simulation {

BodyShape::BodyShape(const RobotConfig& robot)
    : tracks_{robot.length_m, robot.track_gauge_m, kClimb_m},
      half_m_{0.5 * robot.length_m, 0.5 * robot.width_m,
              0.5 * std::max(0.01, robot.height_m - kClimb_m)},
      middle_height_m_{kClimb_m + half_m_.z()},
      reach_m_{half_m_.norm() + middle_height_m_} {}

Contact BodyShape::with_box(const Isometry& T_world_body, const Box& box) const {
  const Isometry T_world_middle = T_world_body * Eigen::Translation3d(0, 0, middle_height_m_);
  return box_contact(T_world_middle, half_m_, box.T_world_box, box.half_size_m);
}

Contact BodyShape::with_person(const Isometry& T_world_body, const Person& person,
                               const PersonPose& pose) const {
  Contact nearest;
  nearest.gap_m = std::numeric_limits<double>::infinity();
  for (const Box& part : person_boxes(person, pose)) {
    const Contact contact = with_box(T_world_body, part);
    if (contact.gap_m < nearest.gap_m) nearest = contact;
  }
  return nearest;
}

}  // namespace cairn::simulation
