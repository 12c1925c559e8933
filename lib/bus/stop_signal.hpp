// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace cairn::bus {

/// SIGINT, SIGTERM and SIGHUP as something to look at, not something that interrupts; SIGPIPE is
/// ignored. To be made before the program has threads.
class StopSignal {
 public:
  StopSignal();
  StopSignal(const StopSignal&) = delete;
  StopSignal& operator=(const StopSignal&) = delete;
  ~StopSignal();

  /// Waits up to `timeout_us` for one; true as soon as one has come, and from then on.
  [[nodiscard]] bool arrived(std::int64_t timeout_us = 0);

 private:
  int fd_;
  bool arrived_ = false;
};

}  // namespace cairn::bus
