// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <set>
#include <string>

namespace cairn::testing {

/// Pids of all processes whose command line has this text, from /proc: the independent truth.
[[nodiscard]] std::multiset<pid_t> processes_with(const std::string& text);

/// Those that a run's folder is named to.
[[nodiscard]] inline std::multiset<pid_t> processes_of(const std::filesystem::path& run) {
  return processes_with(run.string());
}

/// So that a test that failed leaves nothing behind.
void kill_processes_of(const std::filesystem::path& run);

}  // namespace cairn::testing
