// SPDX-License-Identifier: Apache-2.0
#include "bus/host_clock.hpp"

#include <chrono>

namespace cairn::bus {

HostTime SteadyClock::now_us() const {
  return std::chrono::duration_cast<std::chrono::microseconds>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

}  // namespace cairn::bus
