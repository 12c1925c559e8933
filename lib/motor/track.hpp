// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "core/time.hpp"
#include "motor/track_pid.hpp"
#include "motor/track_speed.hpp"

namespace cairn::motor {

/// One track: its speed, the loop that holds it there, and whether it is stuck.
class Track {
 public:
  /// Stalled: for so long of device time driven with a duty that would move it freely at
  /// kStallDrive_mps or more, it did less than a fifth of that.
  static constexpr std::int64_t kStall_us = 1'000'000;
  static constexpr double kStallDrive_mps = 0.1;
  static constexpr double kStallShare = 0.2;
  /// A track that is to stand, and is this slow, is left alone.
  static constexpr double kStanding_mps = 0.01;

  Track(const TrackPidConfig& pid, double max_acceleration_mps2, double ticks_per_m)
      : full_duty_mps_{pid.full_duty_mps}, pid_{pid, max_acceleration_mps2}, speed_{ticks_per_m} {}

  /// A reading, and the duty that was in effect. Device time rises from call to call.
  void add(std::int64_t device_us, std::int64_t ticks, double duty);

  /// The duty for the time up to the next reading.
  [[nodiscard]] double step(double target_mps, double dt_s);

  /// No drive; the next step starts from standing.
  void stand() { pid_.reset(); }

  /// The controller started anew, and its ticks and clock with it.
  void restart();

  [[nodiscard]] double measured_mps() const { return speed_.mps(); }
  /// What the track is held at; 0 while it is given no drive.
  [[nodiscard]] double commanded_mps() const { return pid_.setpoint_mps(); }
  [[nodiscard]] bool stalled() const { return stalled_; }

 private:
  void watch_for_stall(std::int64_t device_us, double duty);

  double full_duty_mps_;
  TrackPid pid_;
  TrackSpeed speed_;
  std::int64_t free_us_ = 0;  ///< when it was last seen to be free
  bool any_ = false;
  bool stalled_ = false;
};

}  // namespace cairn::motor
