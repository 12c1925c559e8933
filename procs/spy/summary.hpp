// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "procs/spy/pace.hpp"

namespace cairn::spy {

struct Latency {
  std::int64_t p50_us = 0;
  std::int64_t p99_us = 0;
};

/// One run of a sending process on one channel.
struct SenderSummary {
  std::int64_t session = 0;
  std::string process;  ///< empty until its PROCESS_STATUS was heard
  std::int64_t count = 0;
  std::int64_t lost = 0;
  std::int64_t age_us = 0;  ///< since its last message
};

struct ChannelSummary {
  std::string channel;
  std::string type;  ///< by the catalogue, else by fingerprint, else "unknown 0x..."
  bool in_catalogue = false;
  std::int64_t count = 0;
  std::int64_t bytes = 0;
  std::optional<Pace> pace;
  std::int64_t lost = 0;          ///< gaps in the senders' sequences
  std::int64_t out_of_order = 0;  ///< sequence numbers that went back within a session
  std::int64_t undecodable = 0;
  std::string last_problem;  ///< why the last one was undecodable
  int restarts = 0;
  std::int64_t age_us = 0;             ///< since the last message
  bool stale = false;                  ///< silent for several of its periods
  std::optional<Latency> latency;      ///< from sending to arrival here; only live
  std::vector<SenderSummary> senders;  ///< newest heard first
};

/// One process, as its last PROCESS_STATUS says.
struct ProcessSummary {
  std::string process;
  int pid = 0;
  std::int64_t session = 0;
  std::string health;  ///< starting, ok, waiting, ill, silent
  std::string reason;
  bool same_types = true;           ///< built with the same message types as this program
  std::optional<double> cpu_share;  ///< of one core; newest second
  std::int64_t rss_bytes = 0;
  std::int64_t uptime_us = 0;
  std::int64_t work_p50_us = 0;
  std::int64_t work_p99_us = 0;
  std::int64_t received = 0;  ///< this and the next four: over all its channels, since its start
  std::int64_t published = 0;
  std::int64_t lost = 0;
  std::int64_t skipped = 0;
  std::int64_t refused = 0;
  int restarts = 0;
  std::int64_t age_us = 0;  ///< since its last PROCESS_STATUS
  std::map<std::string, std::int64_t> counters;
};

struct TrafficSummary {
  std::int64_t span_us = 0;  ///< from the first message to now
  std::int64_t messages = 0;
  std::int64_t bytes = 0;
  std::int64_t lost = 0;
  std::int64_t undecodable = 0;
  std::int64_t ignored = 0;  ///< messages of channels beyond the number that is kept
  std::int64_t time_set_back =
      0;  ///< how often a message was over a second older than the one before
  std::vector<ChannelSummary> channels;   ///< by name
  std::vector<ProcessSummary> processes;  ///< by name
};

}  // namespace cairn::spy
