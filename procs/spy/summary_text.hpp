// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "procs/spy/summary.hpp"
#include "procs/spy/text_table.hpp"

namespace cairn::spy {

/// "12 channels, 617 Hz, 1.20 MB/s, lost 0, undecodable 0, 1,234 messages in 2.00 s".
[[nodiscard]] std::string headline(const TrafficSummary& summary);

/// One row a channel, in the summary's order.
[[nodiscard]] TextTable channel_table(const TrafficSummary& summary);

/// One row a process, in the summary's order.
[[nodiscard]] TextTable process_table(const TrafficSummary& summary);

/// Why messages of a channel could not be decoded, one line for each channel that had any.
[[nodiscard]] std::vector<std::string> problem_lines(const TrafficSummary& summary);

}  // namespace cairn::spy
