// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <optional>

#include "bus/bus.hpp"
#include "bus/node.hpp"
#include "bus/recording.hpp"

namespace cairn::cli {

/// Plays the inputs of a recording (STEREO_FRAME, CALIBRATION, WHEEL_STATE, RANGE, CLOCK; of a
/// depth recording DISPARITY) into a bus, at the recording's pace times `speed`. Never a command,
/// never a result. At most one frame a step, so that in lockstep each frame is worked off before
/// the next. A leap of over five seconds in the recording's times is left out: it is damage, or a
/// pause that nobody misses.
class RecordingPlayer {
 public:
  /// An error says why this is no recording, or that it holds no frames.
  [[nodiscard]] static Result<std::unique_ptr<RecordingPlayer>> create(
      const std::filesystem::path& recording, double speed, bus::Bus& bus, bus::Node& node);

  RecordingPlayer(bus::RecordingReader reader, std::string frame_channel, double speed,
                  bus::Bus& bus, bus::Node& node);

  [[nodiscard]] std::int64_t frames() const { return frames_; }
  /// What was damaged in the recording; empty where it is whole.
  [[nodiscard]] std::string damage() const { return reader_.damage(); }

 private:
  void step();
  void schedule_next(std::int64_t last_recorded_us);
  void play(bus::RawMessage message);
  [[nodiscard]] bool is_input(const std::string& channel) const;

  bus::RecordingReader reader_;
  std::string frame_channel_;
  double speed_;
  bus::Bus& bus_;
  bus::Node& node_;
  std::optional<bus::RecordedMessage> next_;
  std::optional<HostTime> started_us_;
  std::int64_t latest_recorded_us_ = 0;
  double next_due_us_ = 0;  ///< since the beginning, in the recording's time
  std::int64_t frames_ = 0;
};

}  // namespace cairn::cli
