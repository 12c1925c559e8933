// SPDX-License-Identifier: Apache-2.0
#include "procs/localizer/localizer_node.hpp"

#include <algorithm>

#include "messages/check.hpp"
#include "messages/geometry_messages.hpp"

namespace cairn {

namespace channels = bus::channels;

Result<std::unique_ptr<LocalizerNode>> LocalizerNode::create(const Config&, bus::Node& node) {
  return std::make_unique<LocalizerNode>(node);
}

LocalizerNode::LocalizerNode(bus::Node& node) : node_{node} {
  node.on<channels::Odometry>([this](const odometry_t& odometry) { publish_pose(odometry); });
}

void LocalizerNode::publish_pose(const odometry_t& odometry) {
  if (auto good = messages::check(odometry); !good) {
    return node_.refuse(channels::Odometry::name, good.error().message);
  }
  const auto T_odom_body = messages::to_isometry(odometry.T_odom_body, "T_odom_body");
  pose_t pose{};
  pose.T_map_body = messages::to_message(T_map_odom_ * *T_odom_body);
  pose.T_map_odom = messages::to_message(T_map_odom_);
  pose.correction_utime = odometry.header.utime;
  pose.epoch = odometry.epoch;
  pose.state = pose_t::STATE_TRACKING;
  std::copy(std::begin(odometry.covariance), std::end(odometry.covariance),
            std::begin(pose.covariance));
  node_.publish<channels::Pose>(pose, odometry.header.utime);
}

}  // namespace cairn
