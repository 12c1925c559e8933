// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "core/time.hpp"

namespace cairn::motor {

/// The speed of one track from its encoder, over the last three reading periods: at 50 readings a
/// second it is 30 ms old and, at 5000 ticks a metre, good to 3 mm/s.
class TrackSpeed {
 public:
  explicit TrackSpeed(double ticks_per_m) : ticks_per_m_{ticks_per_m} {}

  /// Device time rises from call to call.
  void add(std::int64_t device_us, std::int64_t ticks) {
    for (std::size_t i = 0; i + 1 < readings_.size(); ++i) readings_[i] = readings_[i + 1];
    readings_.back() = {device_us, ticks};
    if (count_ < readings_.size()) ++count_;
  }

  void restart() { count_ = 0; }

  /// 0 before the second reading.
  [[nodiscard]] double mps() const {
    if (count_ < 2) return 0;
    const Reading& oldest = readings_[readings_.size() - count_];
    const Reading& newest = readings_.back();
    return static_cast<double>(newest.ticks - oldest.ticks) / ticks_per_m_ /
           to_seconds(newest.device_us - oldest.device_us);
  }

 private:
  struct Reading {
    std::int64_t device_us;
    std::int64_t ticks;
  };
  double ticks_per_m_;
  std::array<Reading, 4> readings_{};
  std::size_t count_ = 0;
};

}  // namespace cairn::motor
