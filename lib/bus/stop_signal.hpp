// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace cairn::bus {

/// SIGINT and SIGTERM as something to look at, not something that interrupts; SIGPIPE is ignored.
/// To be made before the program has threads.
class StopSignal {
 public:
  StopSignal();
  StopSignal(const StopSignal&) = delete;
  StopSignal& operator=(const StopSignal&) = delete;
  ~StopSignal();

  [[nodiscard]] bool arrived() const;

 private:
  int fd_;
};

}  // namespace cairn::bus
