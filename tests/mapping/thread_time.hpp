// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <ctime>

namespace cairn::mapping::testing {

/// Processor time of this thread [ms]: what other programs do meanwhile is left out.
inline double thread_ms() {
  timespec now{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

}  // namespace cairn::mapping::testing
