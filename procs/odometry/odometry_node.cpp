// SPDX-License-Identifier: Apache-2.0
#include "procs/odometry/odometry_node.hpp"

#include <algorithm>
#include <utility>

#include "messages/check.hpp"
#include "messages/geometry_messages.hpp"
#include "odometry/checkpoint.hpp"

namespace cairn {

namespace channels = bus::channels;

namespace {

constexpr const char* kCheckpoint = "odometry";
constexpr std::int64_t kPeriod_us = 20'000;
/// More frames than come in the longest time that one may have to wait.
constexpr std::size_t kMaxWaiting = 32;
constexpr std::int32_t kFaultNoController = 1;

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
    : config_{config},
      node_{node},
      frames_{node.state()},
      tracks_{config.robot, config.tracks},
      odometry_{config.sight, odometry::TrackModel{config.robot, config.tracks}} {
  resume();
  node.on<channels::Calibration>([this](const rig_calibration_t& calibration) {
    if (auto put = frames_.put(calibration); !put)
      node_.refuse(channels::Calibration::name, put.error().message);
  });
  node.on<channels::StereoFrame>([this](const stereo_frame_t& frame) { take(frame); });
  node.on<channels::WheelState>([this](const wheel_state_t& wheels) { take(wheels); });
  node.every_data(kPeriod_us, [this] { work_off(); });
}

void OdometryNode::resume() {
  const auto bytes = node_.state().load(kCheckpoint);
  if (!bytes) return;
  const auto checkpoint = odometry::checkpoint_from_bytes(*bytes);
  if (!checkpoint) {
    node_.log(bus::Level::kWarning, "the checkpoint is not used: " + checkpoint.error().message);
    return;
  }
  if (checkpoint->tracks) tracks_.add(*checkpoint->tracks);
  odometry_.resume(*checkpoint, tracks_.at(checkpoint->utime));
  node_.log(bus::Level::kInfo,
            "goes on from the pose at utime " + std::to_string(checkpoint->utime));
}

void OdometryNode::remember() {
  const auto saved = node_.state().save(kCheckpoint, odometry::to_bytes(odometry_.checkpoint()));
  if (!saved) node_.log(bus::Level::kWarning, saved.error().message);
}

void OdometryNode::take(const wheel_state_t& wheels) {
  if (auto good = messages::check(wheels); !good)
    return node_.refuse(channels::WheelState::name, good.error().message);
  if ((wheels.faults & kFaultNoController) != 0) {
    ++node_.counter("wheels_without_controller");
    return;
  }
  if (wheels.header.utime <= answered_utime_ - odometry::TrackHistory::kLag_us)
    ++node_.counter("wheels_late");
  const auto added =
      tracks_.add({wheels.header.utime, wheels.left_ticks, wheels.right_ticks, wheels.ticks_per_m,
                   wheels.left_measured_mps, wheels.right_measured_mps});
  if (added == odometry::TrackHistory::Added::kNot) ++node_.counter("wheels_out_of_order");
  if (added == odometry::TrackHistory::Added::kAfresh) ++node_.counter("wheels_began_anew");
  work_off();
}

void OdometryNode::take(const stereo_frame_t& frame) {
  if (answered_utime_ == 0 && waiting_.empty()) tracks_.listens_from(frame.header.utime);
  waiting_.push_back(frame);
  work_off();
}

void OdometryNode::work_off() {
  while (!waiting_.empty()) {
    const Utime now = std::max(node_.data_time(), waiting_.back().header.utime);
    if (!tracks_.ready_for(waiting_.front().header.utime, now) && waiting_.size() <= kMaxWaiting)
      return;
    const stereo_frame_t frame = std::move(waiting_.front());
    waiting_.pop_front();
    update(frame);
  }
}

Result<odometry::OdometryEstimate> OdometryNode::estimate(const stereo_frame_t& frame) {
  const Utime utime = frame.header.utime;
  const auto tracks = tracks_.at(utime);
  if (!config_.visual) {
    if (auto good = messages::check(frame); !good) return tl::make_unexpected(good.error());
    return odometry_.update_blind(utime, tracks);
  }
  const auto pair = frames_.rectify(frame);
  if (!pair) return tl::make_unexpected(pair.error());
  return odometry_.update(pair->left, pair->right, frames_.rectifier().camera(), utime, tracks);
}

void OdometryNode::update(const stereo_frame_t& frame) {
  const auto estimated = estimate(frame);
  if (!estimated) return node_.refuse(channels::StereoFrame::name, estimated.error().message);
  answered_utime_ = estimated->utime;
  count(*estimated);
  node_.publish<channels::Odometry>(to_message(*estimated), estimated->utime);
  if (auto settled = odometry_.settle(); !settled)
    node_.refuse(channels::StereoFrame::name, settled.error().message);
  remember();
}

void OdometryNode::count(const odometry::OdometryEstimate& estimate) {
  using odometry::Dispute;
  if (estimate.coasting) ++node_.counter("coasting");
  if (estimate.basis == odometry::Basis::kTracks) ++node_.counter("by_tracks_alone");
  if (estimate.dispute == Dispute::kTracksOverruled) ++node_.counter("tracks_overruled");
  if (estimate.dispute == Dispute::kSightOverruled) ++node_.counter("sight_overruled");
  if (estimate.dispute == Dispute::kMoverLeftOut) ++node_.counter("movers_left_out");
}

}  // namespace cairn
