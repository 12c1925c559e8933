// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace cairn {

/// Data time [us]: the capture time of what a message rests on. Algorithms use nothing else, so
/// that a recording played back is the same run again.
using Utime = std::int64_t;

/// Host time [us]: the monotonic clock of this machine, for heartbeats, back-off, latency and
/// dead-man timers.
using HostTime = std::int64_t;

inline constexpr std::int64_t kMicrosecondsPerSecond = 1'000'000;

[[nodiscard]] constexpr double to_seconds(std::int64_t duration_us) {
  return static_cast<double>(duration_us) / 1e6;
}

}  // namespace cairn
