// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cairn/process_status_t.hpp>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "procs/spy/summary.hpp"

namespace cairn::spy {

/// The processes that PROCESS_STATUS tells of, one row for each run that no later run of the
/// same process has replaced.
class ProcessTable {
 public:
  void add(const process_status_t& status, std::int64_t time_us);

  /// Empty for a session that no PROCESS_STATUS was heard of.
  [[nodiscard]] std::string name_of(std::int64_t session) const;

  [[nodiscard]] std::vector<ProcessSummary> summary(std::int64_t now_us) const;

 private:
  struct Run {
    process_status_t status;
    std::optional<double> cpu_share;
    std::int64_t first_us = 0;
    std::int64_t last_us = 0;
  };
  [[nodiscard]] ProcessSummary row(const Run& run, std::int64_t now_us) const;
  [[nodiscard]] bool replaced(const Run& run) const;

  std::map<std::int64_t, Run> runs_;  ///< by session
};

}  // namespace cairn::spy
