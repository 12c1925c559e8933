// SPDX-License-Identifier: Apache-2.0
#include "simulation/body_shape.hpp"

#include <algorithm>
#include <cmath>

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

Contact BodyShape::with_person(const Isometry& T_world_body, const Eigen::Vector2d& at_m,
                               double radius_m) const {
  const Eigen::Vector2d ahead = T_world_body.linear().col(0).head<2>().normalized();
  const Eigen::Vector2d left(-ahead.y(), ahead.x());
  const Eigen::Vector2d half_m = half_m_.head<2>();
  const Eigen::Vector2d to_person =
      at_m - (T_world_body * Eigen::Vector3d(0, 0, middle_height_m_)).head<2>();
  const Eigen::Vector2d there(ahead.dot(to_person), left.dot(to_person));
  const Eigen::Vector2d nearest = there.cwiseMax(-half_m).cwiseMin(half_m);
  const Eigen::Vector2d between = there - nearest;
  const double distance_m = between.norm();
  if (distance_m > 0) {
    const Eigen::Vector2d away = -between / distance_m;
    return {distance_m - radius_m, away.x() * ahead + away.y() * left};
  }
  const Eigen::Vector2d inside_m = half_m - there.cwiseAbs();
  if (inside_m.x() < inside_m.y())
    return {-inside_m.x() - radius_m, std::copysign(1.0, -there.x()) * ahead};
  return {-inside_m.y() - radius_m, std::copysign(1.0, -there.y()) * left};
}

}  // namespace cairn::simulation
