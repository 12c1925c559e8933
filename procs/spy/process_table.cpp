// SPDX-License-Identifier: Apache-2.0
#include "procs/spy/process_table.hpp"

#include <algorithm>
#include <array>
#include <tuple>

#include "bus/channels.hpp"
#include "core/time.hpp"
#include "procs/spy/saturating.hpp"
#include "procs/spy/succession.hpp"

namespace cairn::spy {
namespace {

constexpr std::size_t kMostRuns = 256;
/// Silence that means: it hangs or is gone (process_status_t.lcm).
constexpr std::int64_t kSilent_us = 2 * kMicrosecondsPerSecond;

std::string health_name(const process_status_t& status, std::int64_t age_us) {
  constexpr std::array<const char*, 4> kNames{"starting", "ok", "waiting", "ill"};
  if (age_us > kSilent_us) return "silent";
  if (status.health < 0 || static_cast<std::size_t>(status.health) >= kNames.size())
    return "unknown";
  return kNames[static_cast<std::size_t>(status.health)];
}

/// Share of one core between two statuses of a run.
std::optional<double> cpu_share(const process_status_t& from, const process_status_t& to) {
  const double elapsed_s = to_seconds(to.uptime_us) - to_seconds(from.uptime_us);
  if (!(elapsed_s > 0)) return std::nullopt;
  return (to.cpu_s - from.cpu_s) / elapsed_s;
}

}  // namespace

void ProcessTable::add(const process_status_t& status, std::int64_t time_us) {
  const std::int64_t session = status.header.session;
  if (const auto known = runs_.find(session); known != runs_.end()) {
    Run& run = known->second;
    run.cpu_share = cpu_share(run.status, status);
    run.status = status;
    run.last_us = time_us;
    return;
  }
  if (runs_.size() >= kMostRuns) {
    runs_.erase(std::min_element(runs_.begin(), runs_.end(), [](const auto& a, const auto& b) {
      return a.second.last_us < b.second.last_us;
    }));
  }
  runs_.emplace(session, Run{status, cpu_share(process_status_t{}, status), time_us, time_us});
}

std::string ProcessTable::name_of(std::int64_t session) const {
  const auto run = runs_.find(session);
  return run == runs_.end() ? "" : run->second.status.process;
}

bool ProcessTable::replaced(const Run& run) const {
  return std::any_of(runs_.begin(), runs_.end(), [&](const auto& other) {
    return other.second.status.process == run.status.process && other.second.first_us > run.last_us;
  });
}

ProcessSummary ProcessTable::row(const Run& run, std::int64_t now_us) const {
  const process_status_t& status = run.status;
  ProcessSummary row;
  row.process = status.process;
  row.pid = status.pid;
  row.session = status.header.session;
  row.age_us = age(now_us, run.last_us);
  row.health = health_name(status, row.age_us);
  row.reason = status.reason;
  row.same_types = status.types_hash == bus::types_hash();
  row.cpu_share = run.cpu_share;
  row.rss_bytes = status.rss_bytes;
  row.uptime_us = status.uptime_us;
  row.work_p50_us = status.work_p50_us;
  row.work_p99_us = status.work_p99_us;
  for (const channel_status_t& channel : status.channels) {
    row.received = saturating_sum(row.received, channel.received);
    row.published = saturating_sum(row.published, channel.published);
    row.lost = saturating_sum(row.lost, channel.lost);
    row.skipped = saturating_sum(row.skipped, channel.skipped);
    row.refused = saturating_sum(row.refused, channel.refused);
  }
  for (const counter_t& counter : status.counters) row.counters[counter.name] = counter.value;
  std::vector<HeardRun> runs;
  for (const auto& [session, other] : runs_) {
    if (other.status.process == status.process)
      runs.push_back({status.process, other.first_us, other.last_us});
  }
  row.restarts = restarts_in(std::move(runs));
  return row;
}

std::vector<ProcessSummary> ProcessTable::summary(std::int64_t now_us) const {
  std::vector<ProcessSummary> rows;
  for (const auto& [session, run] : runs_) {
    if (!replaced(run)) rows.push_back(row(run, now_us));
  }
  std::sort(rows.begin(), rows.end(), [](const ProcessSummary& a, const ProcessSummary& b) {
    return std::tie(a.process, a.session) < std::tie(b.process, b.session);
  });
  return rows;
}

}  // namespace cairn::spy
