// SPDX-License-Identifier: Apache-2.0
#include "procs/stereo/stereo_node.hpp"

#include "messages/disparity_messages.hpp"

namespace cairn {

namespace channels = bus::channels;

Result<void> StereoNode::check(const Config& config) {
  const auto matcher = stereo::make_matcher(config);
  return matcher ? Result<void>{} : tl::make_unexpected(matcher.error());
}

Result<std::unique_ptr<StereoNode>> StereoNode::create(const Config& config, bus::Node& node) {
  auto matcher = stereo::make_matcher(config);
  if (!matcher) return tl::make_unexpected(matcher.error());
  return std::make_unique<StereoNode>(std::move(*matcher), node);
}

StereoNode::StereoNode(std::unique_ptr<stereo::Matcher> matcher, bus::Node& node)
    : node_{node}, frames_{node.state()}, matcher_{std::move(matcher)} {
  node.on<channels::Calibration>([this](const rig_calibration_t& calibration) {
    if (auto put = frames_.put(calibration); !put)
      node_.refuse(channels::Calibration::name, put.error().message);
  });
  node.on<channels::StereoFrame>([this](const stereo_frame_t& frame) { match(frame); });
}

void StereoNode::match(const stereo_frame_t& frame) {
  const auto pair = frames_.rectify(frame);
  if (!pair) return node_.refuse(channels::StereoFrame::name, pair.error().message);
  auto seen =
      matcher_->match(pair->left, pair->right, frames_.rectifier().camera(), frame.header.utime);
  if (!seen) return node_.refuse(channels::StereoFrame::name, seen.error().message);
  auto message = messages::to_message(*seen, static_cast<std::uint64_t>(frame.calibration_id));
  if (!message) return node_.refuse(channels::Disparity::name, message.error().message);
  node_.publish<channels::Disparity>(std::move(*message), frame.header.utime);
}

}  // namespace cairn
