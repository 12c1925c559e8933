// SPDX-License-Identifier: Apache-2.0
#include "procs/spy/summary_text.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "procs/spy/printable.hpp"
#include "procs/spy/quantities.hpp"

namespace cairn::spy {
namespace {

constexpr const char* kNotKnown = "-";
constexpr std::size_t kLongestName = 32;
constexpr std::size_t kLongestReason = 60;

std::string duration(std::int64_t duration_us) {
  return duration_text(static_cast<double>(duration_us));
}

std::string name(const std::string& text) { return shortened(printable(text), kLongestName); }

/// "0.4 (32-35)": standard deviation of the intervals, the shortest and the longest.
std::string jitter(const std::optional<Pace>& pace) {
  if (!pace) return kNotKnown;
  char text[80];
  std::snprintf(text, sizeof(text), "%.1f (%.0f-%.0f)", pace->std_interval_us / 1e3,
                pace->min_interval_us / 1e3, pace->max_interval_us / 1e3);
  return text;
}

std::string latency(const std::optional<Latency>& latency) {
  if (!latency) return kNotKnown;
  return duration(latency->p50_us) + " / " + duration(latency->p99_us);
}

std::string sender(const ChannelSummary& channel) {
  if (channel.senders.empty()) return kNotKnown;
  const SenderSummary& newest = channel.senders.front();
  char session[16];
  std::snprintf(session, sizeof(session), "#%06llx",
                static_cast<unsigned long long>(newest.session) & 0xffffff);
  std::string text = newest.process.empty() ? session : name(newest.process);
  const std::size_t speaking =
      channel.senders.size() - static_cast<std::size_t>(std::min(
                                   channel.restarts, static_cast<int>(channel.senders.size()) - 1));
  if (speaking > 1) text += " +" + std::to_string(speaking - 1);
  if (channel.restarts > 0) text += " (restarted " + std::to_string(channel.restarts) + "x)";
  return text;
}

std::string health(const ProcessSummary& process) {
  return process.same_types ? process.health : process.health + ", other types";
}

}  // namespace

std::string headline(const TrafficSummary& summary) {
  double messages_per_s = 0;
  double bytes_per_s = 0;
  for (const ChannelSummary& channel : summary.channels) {
    if (!channel.pace) continue;
    messages_per_s += channel.pace->rate_hz;
    bytes_per_s += channel.pace->bytes_per_s;
  }
  std::string text = std::to_string(summary.channels.size()) + " channels, " +
                     rate_text(messages_per_s) + " Hz, " + bytes_text(bytes_per_s) + "/s, lost " +
                     grouped(summary.lost) + ", undecodable " + grouped(summary.undecodable) +
                     ", " + grouped(summary.messages) + " messages in " + duration(summary.span_us);
  if (summary.ignored > 0) text += ", too many channels: ignored " + grouped(summary.ignored);
  if (summary.time_set_back > 0) text += ", time set back " + grouped(summary.time_set_back) + "x";
  return text;
}

TextTable channel_table(const TrafficSummary& summary) {
  TextTable table({{"channel"},
                   {"type", false, 8},
                   {"count", true, 7},
                   {"Hz", true},
                   {"jitter (min-max) ms", true, 9},
                   {"per s", true, 3},
                   {"lost", true},
                   {"bad", true, 1},
                   {"latency p50 / p99", true, 5},
                   {"age", true, 2},
                   {"sender", false, 4}});
  for (const ChannelSummary& channel : summary.channels) {
    const auto& pace = channel.pace;
    table.add({name(channel.channel), name(channel.type) + (channel.in_catalogue ? "" : " ?"),
               grouped(channel.count), pace ? rate_text(pace->rate_hz) : kNotKnown, jitter(pace),
               pace ? bytes_text(pace->bytes_per_s) : kNotKnown, grouped(channel.lost),
               grouped(channel.undecodable), latency(channel.latency),
               duration(channel.age_us) + (channel.stale ? " stale" : ""), sender(channel)});
  }
  return table;
}

TextTable process_table(const TrafficSummary& summary) {
  TextTable table({{"process"},
                   {"pid", true, 8},
                   {"health"},
                   {"cpu %", true},
                   {"memory", true, 3},
                   {"work p50 / p99", true, 4},
                   {"lost", true, 1},
                   {"skipped", true, 1},
                   {"refused", true, 1},
                   {"restarts", true, 6},
                   {"age", true, 7},
                   {"reason", false, 2}});
  for (const ProcessSummary& process : summary.processes) {
    char cpu[32] = "-";
    if (process.cpu_share && std::isfinite(*process.cpu_share))
      std::snprintf(cpu, sizeof(cpu), "%.1f", 100 * *process.cpu_share);
    table.add({name(process.process), std::to_string(process.pid), health(process), cpu,
               bytes_text(static_cast<double>(process.rss_bytes)),
               duration(process.work_p50_us) + " / " + duration(process.work_p99_us),
               grouped(process.lost), grouped(process.skipped), grouped(process.refused),
               std::to_string(process.restarts), duration(process.age_us),
               shortened(printable(process.reason), kLongestReason)});
  }
  return table;
}

std::vector<std::string> problem_lines(const TrafficSummary& summary) {
  std::vector<std::string> lines;
  for (const ChannelSummary& channel : summary.channels) {
    if (channel.undecodable > 0)
      lines.push_back(name(channel.channel) + ": " + printable(channel.last_problem));
  }
  return lines;
}

}  // namespace cairn::spy
