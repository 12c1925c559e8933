// SPDX-License-Identifier: Apache-2.0
#include "procs/camera/camera_node.hpp"

#include <algorithm>
#include <cstring>

#include "core/checksum.hpp"
#include "messages/calibration_messages.hpp"
#include "messages/disparity_messages.hpp"
#include "procs/camera/open_source.hpp"
#include "stereo/depth_to_disparity.hpp"
#include "stereo/rectifier.hpp"

namespace cairn {
namespace {

constexpr const char* kPosition = "position";
constexpr std::int64_t kCalibrationPeriod_us = kMicrosecondsPerSecond;
constexpr std::int64_t kClockPeriod_us = 50'000;
/// A live camera is asked for its next pair at once; next() waits for it.
constexpr std::int64_t kLivePollPeriod_us = 1'000;
/// After a failure it is given this long.
constexpr std::int64_t kRetry_us = 500'000;

/// What a restarted camera goes on with.
struct Position {
  std::uint64_t recording_id;
  std::int64_t next_index;
  std::int32_t jpeg_quality;
};

}  // namespace

Result<std::unique_ptr<CameraNode>> CameraNode::create(const Config& config, bus::Node& node) {
  auto source = open_source(config, node);
  if (!source) return tl::make_unexpected(source.error());
  return std::make_unique<CameraNode>(config, std::move(*source), node);
}

CameraNode::CameraNode(const Config& config, std::unique_ptr<camera::FrameSource> source,
                       bus::Node& node)
    : config_{config},
      source_{std::move(source)},
      node_{node},
      rig_{messages::as_sent(source_->rig())},
      encoder_{
          config.encoding == "raw" ? messages::ImageEncoding::kRaw : messages::ImageEncoding::kJpeg,
          config.frame_budget_bytes} {
  const bool live = !source_->size().has_value();
  const auto frame_period_us = static_cast<std::int64_t>(1e6 / (source_->rate_hz() * config.speed));
  if (!live) resume();
  publish_calibration();
  node.every_host(kCalibrationPeriod_us, [this] { publish_calibration(); });
  node.every_host(live ? kLivePollPeriod_us : std::max<std::int64_t>(1, frame_period_us),
                  [this] { publish_next_frame(); });
  node.every_host(kClockPeriod_us, [this] { tick_between_frames(); });
}

void CameraNode::resume() {
  const auto bytes = node_.state().load(kPosition);
  Position position{};
  if (!bytes || bytes->size() != sizeof(position)) return;
  std::memcpy(&position, bytes->data(), sizeof(position));
  if (position.recording_id != recording_id()) return;
  source_->seek(position.next_index);
  encoder_.set_quality(position.jpeg_quality);
  node_.log(bus::Level::kInfo, "goes on at frame " + std::to_string(position.next_index));
}

// Tells one recording from another, so that a position in one is not taken for one in the other.
std::uint64_t CameraNode::recording_id() const {
  const std::string name = config_.source + "\n" + config_.dataset + "\n" + config_.video_left +
                           "\n" + std::to_string(source_->size().value_or(0));
  return fnv1a_64({reinterpret_cast<const std::uint8_t*>(name.data()), name.size()}, rig_.id);
}

void CameraNode::remember(std::int64_t next_index) {
  Position position{};
  position.recording_id = recording_id();
  position.next_index = next_index;
  position.jpeg_quality = encoder_.quality();
  std::vector<std::uint8_t> bytes(sizeof(position));
  std::memcpy(bytes.data(), &position, sizeof(position));
  if (auto saved = node_.state().save(kPosition, bytes); !saved) {
    node_.log(bus::Level::kWarning, saved.error().message);
  }
}

void CameraNode::publish_calibration() {
  node_.publish<bus::channels::Calibration>(messages::to_message(rig_, node_.data_time()),
                                            node_.data_time());
}

void CameraNode::publish_clock(Utime utime) {
  cairn::clock_t tick{};
  tick.rate = source_->size() ? config_.speed : 1.0;
  node_.publish<bus::channels::Clock>(tick, utime);
}

// Between two frames data time goes on at its rate, but never past where the next frame may be.
void CameraNode::tick_between_frames() {
  if (!last_utime_) return;
  const double rate = source_->size() ? config_.speed : 1.0;
  const double since_frame_us = rate * static_cast<double>(node_.host_time() - last_frame_host_us_);
  const double frame_period_us = 1e6 / source_->rate_hz();
  publish_clock(*last_utime_ + static_cast<Utime>(std::min(since_frame_us, 0.9 * frame_period_us)));
}

void CameraNode::publish_next_frame() {
  if (source_->finished()) {
    node_.log(bus::Level::kInfo,
              "the recording is at its end; " + std::to_string(published_) + " frames published");
    node_.request_stop();
    return;
  }
  if (node_.host_time() < retry_us_) return;
  const auto frame = source_->next();
  if (!frame) return take_error(frame.error().message);
  node_.set_health(bus::Health::kOk, "");
  publish_clock(frame->utime);
  if (!publish_frame(*frame)) return;
  ++published_;
  last_utime_ = frame->utime;
  last_frame_host_us_ = node_.host_time();
  if (source_->size()) remember(frame->index + 1);
}

void CameraNode::take_error(const std::string& why) {
  node_.refuse(bus::channels::StereoFrame::name, why);
  if (source_->size()) return;
  node_.set_health(bus::Health::kIll, why);
  retry_us_ = node_.host_time() + kRetry_us;
}

bool CameraNode::publish_frame(const camera::Frame& frame) {
  return source_->is_depth() ? publish_depth(frame) : publish_stereo(frame);
}

bool CameraNode::publish_stereo(const camera::Frame& frame) {
  auto message = encoder_.encode(frame, rig_.id);
  if (!message) {
    node_.refuse(bus::channels::StereoFrame::name, message.error().message);
    return false;
  }
  return node_.publish<bus::channels::StereoFrame>(std::move(*message), frame.utime);
}

bool CameraNode::publish_depth(const camera::Frame& frame) {
  const auto rectifier = stereo::Rectifier::create(rig_);
  if (!rectifier) {
    node_.refuse(bus::channels::Disparity::name, rectifier.error().message);
    return false;
  }
  const auto disparity = stereo::disparity_from_depth(frame.depth_m, rectifier->camera(),
                                                      config_.depth_step_px, frame.utime);
  auto message = !disparity ? tl::make_unexpected(disparity.error())
                            : messages::to_message(*disparity, rig_.id);
  if (!message) {
    node_.refuse(bus::channels::Disparity::name, message.error().message);
    return false;
  }
  return node_.publish<bus::channels::Disparity>(std::move(*message), frame.utime);
}

}  // namespace cairn
