// SPDX-License-Identifier: Apache-2.0
#include "procs/odometry/odometry_node.hpp"

#include "messages/geometry_messages.hpp"
#include "odometry/checkpoint.hpp"

namespace cairn {

namespace channels = bus::channels;

namespace {

constexpr const char* kCheckpoint = "odometry";

odometry_t to_message(const odometry::OdometryEstimate& estimate) {
  odometry_t message{};
  message.T_odom_body = messages::to_message(estimate.T_odom_body);
  message.twist =
      messages::to_message(messages::Twist{estimate.twist.head<3>(), estimate.twist.tail<3>()});
  messages::set_covariance(message.covariance, estimate.step_covariance);
  message.quality = estimate.quality;
  message.epoch = static_cast<std::int32_t>(estimate.epoch);
  message.tracked = estimate.tracked;
  message.inliers = estimate.inliers;
  return message;
}

}  // namespace

Result<std::unique_ptr<OdometryNode>> OdometryNode::create(const Config& config, bus::Node& node) {
  return std::make_unique<OdometryNode>(config, node);
}

OdometryNode::OdometryNode(const Config& config, bus::Node& node)
    : node_{node}, frames_{node.state()}, odometry_{config} {
  resume();
  node.on<channels::Calibration>([this](const rig_calibration_t& calibration) {
    if (auto put = frames_.put(calibration); !put)
      node_.refuse(channels::Calibration::name, put.error().message);
  });
  node.on<channels::StereoFrame>([this](const stereo_frame_t& frame) { update(frame); });
}

void OdometryNode::resume() {
  const auto bytes = node_.state().load(kCheckpoint);
  if (!bytes) return;
  const auto checkpoint = odometry::checkpoint_from_bytes(*bytes);
  if (!checkpoint) {
    node_.log(bus::Level::kWarning, "the checkpoint is not used: " + checkpoint.error().message);
    return;
  }
  odometry_.resume(*checkpoint);
  node_.log(bus::Level::kInfo,
            "goes on from the pose at utime " + std::to_string(checkpoint->utime));
}

void OdometryNode::remember() {
  const auto saved = node_.state().save(kCheckpoint, odometry::to_bytes(odometry_.checkpoint()));
  if (!saved) node_.log(bus::Level::kWarning, saved.error().message);
}

void OdometryNode::update(const stereo_frame_t& frame) {
  const auto pair = frames_.rectify(frame);
  if (!pair) return node_.refuse(channels::StereoFrame::name, pair.error().message);
  const auto estimate =
      odometry_.update(pair->left, pair->right, frames_.rectifier().camera(), frame.header.utime);
  if (!estimate) return node_.refuse(channels::StereoFrame::name, estimate.error().message);
  if (estimate->coasting) ++node_.counter("coasting");
  node_.publish<channels::Odometry>(to_message(*estimate), frame.header.utime);
  remember();
}

}  // namespace cairn
