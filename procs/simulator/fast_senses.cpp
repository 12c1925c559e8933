// SPDX-License-Identifier: Apache-2.0
#include "procs/simulator/fast_senses.hpp"

#include "messages/disparity_messages.hpp"
#include "messages/geometry_messages.hpp"

namespace cairn {

Result<disparity_t> FastSenses::disparity(const Capture& capture) const {
  return messages::to_message(
      disparity_.see(capture.T_world_body, capture.index, capture.utime, capture.people),
      calibration_id_);
}

odometry_t FastSenses::odometry(const Capture& capture) {
  const auto step = odometry_.step(capture.T_world_body, capture.utime);
  odometry_t message{};
  message.T_odom_body = messages::to_message(step.T_odom_body);
  message.twist = messages::to_message(messages::Twist{step.linear_mps, step.angular_radps});
  messages::set_covariance(message.covariance, messages::Covariance6(step.variance.asDiagonal()));
  message.quality = 1;
  return message;
}

}  // namespace cairn
