// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>

#include "core/time.hpp"

namespace cairn {

/// Holds frames back, where time runs faster than life, until the robot has made of the former ones
/// what it does in time in life: frame k + 2 waits for DISPARITY(k) and POSE(k), frame k + 8 for
/// the MAP_DELTA that is complete through k (DESIGN rule 4). What does not come within kPatience_us
/// of host time is waited for no more until it is heard of again.
class FeedbackGate {
 public:
  static constexpr HostTime kPatience_us = 2 * kMicrosecondsPerSecond;

  /// `waits_for_disparity`: somebody else makes it.
  explicit FeedbackGate(bool waits_for_disparity);

  void frame_taken(Utime utime);
  void hear_disparity(Utime utime) { hear(streams_[0], utime); }
  void hear_pose(Utime utime) { hear(streams_[1], utime); }
  /// Of a MAP_DELTA: the frame through which the map is complete.
  void hear_map(Utime through) { hear(streams_[2], through); }

  /// What the next frame waits for, in words; nothing if it may be taken.
  [[nodiscard]] std::optional<std::string> waits_for(HostTime now_us);

 private:
  struct Stream {
    const char* name;
    std::size_t frames_ago;  ///< the next frame needs this stream's answer to so old a frame
    bool awaited = true;
    Utime newest = 0;
  };
  void hear(Stream& stream, Utime utime);
  [[nodiscard]] bool lacks(const Stream& stream) const;

  std::array<Stream, 3> streams_;
  std::deque<Utime> taken_;  ///< the newest in front
  std::optional<HostTime> waiting_since_us_;
};

}  // namespace cairn
