// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "bus/bus.hpp"
#include "procs/spy/channel_traffic.hpp"
#include "procs/spy/lcm_schema.hpp"
#include "procs/spy/process_table.hpp"
#include "procs/spy/summary.hpp"

namespace cairn::spy {

/// What goes over a bus, counted. Knows no clock and no bus: whoever hears a message says when.
/// The schema must outlive it.
class Traffic {
 public:
  Traffic(const Schema& schema, PaceWindow window, Timing timing)
      : schema_{&schema}, window_{window}, timing_{timing} {}

  /// `time_us`: host time of arrival, or the time that a recording says. LCM's own self-test is
  /// passed over.
  void add(bus::RawMessage message, std::int64_t time_us);

  [[nodiscard]] TrafficSummary summary(std::int64_t now_us) const;

  /// The last whole message of each channel that had one.
  [[nodiscard]] std::map<std::string, NewestMessage, std::less<>> newest() const;

  /// When the last message came; 0 before the first.
  [[nodiscard]] std::int64_t last_us() const { return last_us_; }

 private:
  const Schema* schema_;
  PaceWindow window_;
  Timing timing_;
  std::map<std::string, ChannelTraffic, std::less<>> channels_;
  ProcessTable processes_;
  std::int64_t messages_ = 0;
  std::int64_t bytes_ = 0;
  std::int64_t ignored_ = 0;
  std::int64_t time_set_back_ = 0;
  std::int64_t first_us_ = 0;
  std::int64_t last_us_ = 0;
};

}  // namespace cairn::spy
