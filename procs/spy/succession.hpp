// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace cairn::spy {

/// One run of a process, as far as it was heard.
struct HeardRun {
  std::string process;  ///< empty where not known
  std::int64_t first_us = 0;
  std::int64_t last_us = 0;
};

/// How many of these runs took over from an earlier one of the same process: one that had fallen
/// silent for good before they began. Two that speak at the same time are two processes.
[[nodiscard]] int restarts_in(std::vector<HeardRun> runs);

}  // namespace cairn::spy
