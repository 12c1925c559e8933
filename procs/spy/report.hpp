// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "procs/spy/feed.hpp"
#include "procs/spy/lcm_schema.hpp"
#include "procs/spy/options.hpp"

namespace cairn::spy {

/// What is being looked at, for people: the recording, or the bus's address.
[[nodiscard]] std::string source_of(const Options& options);

/// One report as --json prints it: `to_json` of the traffic, with `source`, `live`, `damage` (null
/// when live), and with --channel `message` (null before the first).
[[nodiscard]] std::string json_report(const Schema& schema, const Options& options,
                                      const Snapshot& snapshot);

/// One report for people; with --channel, that channel's newest message.
[[nodiscard]] std::string text_report(const Schema& schema, const Options& options,
                                      const Snapshot& snapshot);

/// What a report cannot show because nothing was heard, and what to look at; empty where all was.
[[nodiscard]] std::string hint(const Options& options, const Snapshot& snapshot);

}  // namespace cairn::spy
