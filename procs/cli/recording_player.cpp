// SPDX-License-Identifier: Apache-2.0
#include "procs/cli/recording_player.hpp"

#include <cmath>

#include "bus/channels.hpp"
#include "bus/codec.hpp"

namespace cairn::cli {
namespace {

constexpr std::int64_t kStepPeriod_us = 1000;
constexpr std::int64_t kLongestPause_us = 5 * kMicrosecondsPerSecond;

// STEREO_FRAME where there are any, else DISPARITY.
Result<std::string> frame_channel_of(bus::RecordingReader& reader,
                                     const std::filesystem::path& recording) {
  bool has_disparity = false;
  while (const auto event = reader.next()) {
    if (event->message.channel == bus::channels::StereoFrame::name) return event->message.channel;
    has_disparity = has_disparity || event->message.channel == bus::channels::Disparity::name;
  }
  if (has_disparity) return std::string(bus::channels::Disparity::name);
  return fail(recording.string() + ": holds no STEREO_FRAME and no DISPARITY" +
              (reader.damage().empty() ? "" : "; " + reader.damage()));
}

}  // namespace

Result<std::unique_ptr<RecordingPlayer>> RecordingPlayer::create(
    const std::filesystem::path& recording, double speed, bus::Bus& bus, bus::Node& node) {
  auto reader = bus::RecordingReader::open(recording);
  if (!reader) return tl::make_unexpected(reader.error());
  auto frame_channel = frame_channel_of(*reader, recording);
  if (!frame_channel) return tl::make_unexpected(frame_channel.error());
  reader->rewind();
  return std::make_unique<RecordingPlayer>(std::move(*reader), std::move(*frame_channel), speed,
                                           bus, node);
}

RecordingPlayer::RecordingPlayer(bus::RecordingReader reader, std::string frame_channel,
                                 double speed, bus::Bus& bus, bus::Node& node)
    : reader_{std::move(reader)},
      frame_channel_{std::move(frame_channel)},
      speed_{speed},
      bus_{bus},
      node_{node} {
  next_ = reader_.next();
  latest_recorded_us_ = next_->recorded_us;
  node.every_host(kStepPeriod_us, [this] { step(); });
}

bool RecordingPlayer::is_input(const std::string& channel) const {
  bool input = channel == frame_channel_;
  bus::for_each_channel([&](auto known) {
    input = input || (known.role == bus::Role::kInput && channel == known.name);
  });
  return input;
}

void RecordingPlayer::step() {
  if (!started_us_) started_us_ = node_.host_time();
  const double played_us = speed_ * static_cast<double>(node_.host_time() - *started_us_);
  bool frame_played = false;
  while (next_ && !frame_played && next_due_us_ <= played_us) {
    const std::int64_t recorded_us = next_->recorded_us;
    if (is_input(next_->message.channel)) {
      frame_played = next_->message.channel == frame_channel_;
      frames_ += frame_played ? 1 : 0;
      play(std::move(next_->message));
    }
    next_ = reader_.next();
    if (next_) schedule_next(recorded_us);
  }
  if (next_) return;
  if (!reader_.damage().empty()) node_.log(bus::Level::kWarning, reader_.damage());
  node_.request_stop();
}

// Recorders write neighbours in swapped order now and then; only the latest time so far counts.
void RecordingPlayer::schedule_next(std::int64_t last_recorded_us) {
  const double leap_us =
      static_cast<double>(next_->recorded_us) - static_cast<double>(last_recorded_us);
  if (std::abs(leap_us) > static_cast<double>(kLongestPause_us)) {
    latest_recorded_us_ = next_->recorded_us;
  } else if (next_->recorded_us > latest_recorded_us_) {
    next_due_us_ += static_cast<double>(next_->recorded_us - latest_recorded_us_);
    latest_recorded_us_ = next_->recorded_us;
  }
}

// The bytes as they were recorded, but for the time of sending, which is now.
void RecordingPlayer::play(bus::RawMessage message) {
  constexpr std::size_t kSentOffset = 16;  // behind the fingerprint and header.utime
  const auto now_us = static_cast<std::uint64_t>(node_.host_time());
  for (std::size_t i = 0; i < 8 && message.bytes.size() > kSentOffset + 8; ++i) {
    message.bytes[kSentOffset + i] = static_cast<std::uint8_t>(now_us >> (56 - 8 * i));
  }
  if (auto sent = bus_.publish(message.channel, message.bytes); !sent) {
    node_.refuse(message.channel, sent.error().message);
  }
}

}  // namespace cairn::cli
