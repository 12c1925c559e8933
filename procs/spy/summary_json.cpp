// SPDX-License-Identifier: Apache-2.0
#include "procs/spy/summary_json.hpp"

#include <cstdio>

#include "core/time.hpp"
#include "procs/spy/printable.hpp"

namespace cairn::spy {
namespace {

using Json = nlohmann::ordered_json;

std::string session_text(std::int64_t session) {
  char text[17];
  std::snprintf(text, sizeof(text), "%016llx", static_cast<unsigned long long>(session));
  return text;
}

double to_ms(double duration_us) { return duration_us / 1e3; }

Json text_or_null(const std::string& text) { return text.empty() ? Json() : Json(printable(text)); }

Json intervals(const std::optional<Pace>& pace) {
  if (!pace) return nullptr;
  return {{"min", to_ms(pace->min_interval_us)},
          {"mean", to_ms(pace->mean_interval_us)},
          {"max", to_ms(pace->max_interval_us)},
          {"std", to_ms(pace->std_interval_us)}};
}

Json percentiles_ms(std::int64_t p50_us, std::int64_t p99_us) {
  return {{"p50", to_ms(static_cast<double>(p50_us))}, {"p99", to_ms(static_cast<double>(p99_us))}};
}

Json sender(const SenderSummary& sender) {
  return {{"session", session_text(sender.session)},
          {"process", text_or_null(sender.process)},
          {"count", sender.count},
          {"lost", sender.lost},
          {"age_s", to_seconds(sender.age_us)}};
}

Json channel(const ChannelSummary& channel) {
  const auto& pace = channel.pace;
  Json senders = Json::array();
  for (const SenderSummary& each : channel.senders) senders.push_back(sender(each));
  return {
      {"channel", printable(channel.channel)},
      {"type", channel.type},
      {"in_catalogue", channel.in_catalogue},
      {"count", channel.count},
      {"bytes", channel.bytes},
      {"rate_hz", pace ? Json(pace->rate_hz) : Json()},
      {"interval_ms", intervals(pace)},
      {"bytes_per_s", pace ? Json(pace->bytes_per_s) : Json()},
      {"lost", channel.lost},
      {"out_of_order", channel.out_of_order},
      {"undecodable", channel.undecodable},
      {"last_problem", text_or_null(channel.last_problem)},
      {"restarts", channel.restarts},
      {"latency_ms",
       channel.latency ? percentiles_ms(channel.latency->p50_us, channel.latency->p99_us) : Json()},
      {"age_s", to_seconds(channel.age_us)},
      {"stale", channel.stale},
      {"senders", std::move(senders)}};
}

Json process(const ProcessSummary& process) {
  Json counters = Json::object();
  for (const auto& [name, value] : process.counters) counters[printable(name)] = value;
  return {{"process", printable(process.process)},
          {"pid", process.pid},
          {"session", session_text(process.session)},
          {"health", process.health},
          {"reason", text_or_null(process.reason)},
          {"same_types", process.same_types},
          {"cpu_share", process.cpu_share ? Json(*process.cpu_share) : Json()},
          {"rss_bytes", process.rss_bytes},
          {"uptime_s", to_seconds(process.uptime_us)},
          {"work_ms", percentiles_ms(process.work_p50_us, process.work_p99_us)},
          {"received", process.received},
          {"published", process.published},
          {"lost", process.lost},
          {"skipped", process.skipped},
          {"refused", process.refused},
          {"restarts", process.restarts},
          {"age_s", to_seconds(process.age_us)},
          {"counters", std::move(counters)}};
}

}  // namespace

Json to_json(const TrafficSummary& summary) {
  Json channels = Json::array();
  for (const ChannelSummary& each : summary.channels) channels.push_back(channel(each));
  Json processes = Json::array();
  for (const ProcessSummary& each : summary.processes) processes.push_back(process(each));
  return {{"span_s", to_seconds(summary.span_us)},
          {"messages", summary.messages},
          {"bytes", summary.bytes},
          {"lost", summary.lost},
          {"undecodable", summary.undecodable},
          {"ignored", summary.ignored},
          {"time_set_back", summary.time_set_back},
          {"channels", std::move(channels)},
          {"processes", std::move(processes)}};
}

}  // namespace cairn::spy
