// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>

#include "core/time.hpp"

namespace cairn {

/// Says how far simulated time may have come by now: `speed` times as far as host time.
class SimulatedTime {
 public:
  /// What a process that was held up makes up for; what is more is lost.
  static constexpr HostTime kMakesUp_us = 250'000;

  SimulatedTime(double speed, Utime start, HostTime now_us)
      : speed_{speed}, anchor_{start}, anchor_host_us_{now_us} {}

  /// `reached`: how far it has come. Time lost is added to lost_us().
  [[nodiscard]] Utime due(Utime reached, HostTime now_us) {
    const Utime due = anchor_ + ahead_us(now_us - anchor_host_us_);
    const std::int64_t excess_us = due - reached - ahead_us(kMakesUp_us);
    if (excess_us <= 0) return due;
    anchor_ -= excess_us;
    lost_us_ += excess_us;
    return due - excess_us;
  }

  /// It stands still at `reached`, and makes up for nothing later.
  void hold(Utime reached, HostTime now_us) {
    anchor_ = reached;
    anchor_host_us_ = now_us;
  }

  [[nodiscard]] std::int64_t lost_us() const { return lost_us_; }

 private:
  [[nodiscard]] std::int64_t ahead_us(HostTime host_us) const {
    return static_cast<std::int64_t>(speed_ * static_cast<double>(host_us));
  }

  double speed_;
  Utime anchor_;
  HostTime anchor_host_us_;
  std::int64_t lost_us_ = 0;
};

}  // namespace cairn
