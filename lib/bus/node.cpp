// SPDX-License-Identifier: Apache-2.0
#include "bus/node.hpp"

#include <spdlog/spdlog.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <exception>
#include <fstream>

namespace cairn::bus {
namespace {

constexpr std::int64_t kHeartbeatPeriod_us = kMicrosecondsPerSecond;
constexpr std::int64_t kInputMissing_us = 2 * kMicrosecondsPerSecond;

/// Logging the 1st, 2nd, 4th, 8th ... time says enough and floods nobody.
bool power_of_two(std::int64_t count) { return (count & (count - 1)) == 0; }

double cpu_seconds() {
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

std::int64_t resident_bytes() {
  std::int64_t total_pages = 0;
  std::int64_t resident_pages = 0;
  std::ifstream("/proc/self/statm") >> total_pages >> resident_pages;
  return resident_pages * ::sysconf(_SC_PAGESIZE);
}

channel_status_t to_message(const std::string& channel, const ChannelCounts& counts) {
  channel_status_t status{};
  status.channel = channel;
  status.received = counts.received;
  status.published = counts.published;
  status.lost = counts.lost;
  status.skipped = counts.skipped;
  status.refused = counts.refused;
  status.latency_p50_us = counts.latency.percentile_us(0.5);
  status.latency_p99_us = counts.latency.percentile_us(0.99);
  status.last_refusal = counts.last_refusal;
  return status;
}

}  // namespace

Node::Node(std::string process, Bus& bus, const HostClock& clock, StateFolder state,
           std::int64_t session)
    : process_{std::move(process)},
      bus_{bus},
      clock_{clock},
      state_{std::move(state)},
      session_{session},
      started_us_{clock.now_us()} {
  every_host(kHeartbeatPeriod_us, [this] { publish_status(); });
  host_timers_.front().due_us = started_us_;
  on<channels::Clock>([this](const cairn::clock_t& tick) { set_data_time(tick.header.utime); });
}

Node::Inbox& Node::open_inbox(const char* channel, Backlog backlog) {
  auto [entry, fresh] = inboxes_.try_emplace(channel);
  if (fresh) {
    entry->second.channel = channel;
    entry->second.last_received_us = clock_.now_us();
    counts_[channel];
    if (auto subscribed = bus_.subscribe(channel); !subscribed && wiring_) wiring_ = subscribed;
  }
  entry->second.backlog = static_cast<std::size_t>(backlog);
  return entry->second;
}

void Node::on_raw(std::function<void(const RawMessage&)> handle) {
  on_raw_ = std::move(handle);
  if (auto subscribed = bus_.subscribe(kAllChannels); !subscribed && wiring_) wiring_ = subscribed;
}

void Node::every_host(std::int64_t period_us, std::function<void()> act) {
  host_timers_.push_back({period_us, clock_.now_us() + period_us, std::move(act)});
}

void Node::every_data(std::int64_t period_us, std::function<void()> act) {
  data_timers_.push_back({period_us, 0, std::move(act)});
}

void Node::set_data_time(Utime utime) {
  if (utime < data_time_ - kMicrosecondsPerSecond) {
    ++counter("data_time_set_back");
    for (Timer& timer : data_timers_) timer.due_us = 0;
  } else if (utime < data_time_) {
    return;
  }
  data_time_ = utime;
  run_data_timers();
}

void Node::count_arrival(Inbox& inbox, const header_t& header) {
  ChannelCounts& counts = counts_.find(inbox.channel)->second;
  ++counts.received;
  inbox.last_received_us = clock_.now_us();
  const auto [last, fresh] = inbox.last_sequence.try_emplace(header.session, header.sequence);
  if (fresh) {
    // A sender that was replaced does not come back; a map that only grows would be a leak.
    if (inbox.last_sequence.size() > 256) inbox.last_sequence = {{header.session, header.sequence}};
    return;
  }
  if (header.sequence > last->second) counts.lost += header.sequence - last->second - 1;
  last->second = header.sequence;
}

void Node::enqueue(Inbox& inbox, std::function<void()> act, HostTime sent_us) {
  pending_.push_back({&inbox, std::move(act), sent_us});
  const auto same_inbox = [&](const Work& work) { return work.inbox == &inbox; };
  if (static_cast<std::size_t>(std::count_if(pending_.begin(), pending_.end(), same_inbox)) <=
      inbox.backlog) {
    return;
  }
  pending_.erase(std::find_if(pending_.begin(), pending_.end(), same_inbox));
  ++counts_.find(inbox.channel)->second.skipped;
}

header_t Node::next_header(const char* channel, Utime utime) {
  header_t header{};
  header.utime = utime;
  header.sent_steady_us = clock_.now_us();
  header.session = session_;
  header.sequence = next_sequence_[channel]++;
  return header;
}

bool Node::send(const char* channel, const std::vector<std::uint8_t>& bytes) {
  const auto sent = bus_.publish(channel, bytes);
  if (!sent) return count_unsent(channel, sent.error());
  ++counts_[channel].published;
  return true;
}

bool Node::count_unsent(const char* channel, const Error& error) {
  std::int64_t& unsent = counter("unsent");
  ++unsent;
  if (power_of_two(unsent))
    spdlog::error("{}: {} was not sent: {}", process_, channel, error.message);
  return false;
}

void Node::refuse(std::string_view channel, const std::string& reason) {
  ChannelCounts& counts = counts_[std::string(channel)];
  ++counts.refused;
  counts.last_refusal = reason;
  if (power_of_two(counts.refused)) {
    log(Level::kWarning, std::string(channel) + ": refused (" + std::to_string(counts.refused) +
                             " so far): " + reason);
  }
}

void Node::log(Level level, const std::string& text) {
  constexpr spdlog::level::level_enum kSpdlogLevels[] = {spdlog::level::debug, spdlog::level::info,
                                                         spdlog::level::warn, spdlog::level::err};
  spdlog::log(kSpdlogLevels[static_cast<int>(level)], "{}: {}", process_, text);
  log_line_t line{};
  line.process = process_;
  line.level = static_cast<std::int8_t>(level);
  line.text = text;
  publish<channels::LogLine>(std::move(line), data_time_);
}

void Node::set_health(Health health, const std::string& reason) {
  health_ = health;
  health_reason_ = reason;
}

std::pair<Health, std::string> Node::observed_health() const {
  if (health_ != Health::kOk) return {health_, health_reason_};
  for (const auto& [channel, inbox] : inboxes_) {
    const HostTime silent_us = clock_.now_us() - inbox.last_received_us;
    const bool streamed = channel == channels::StereoFrame::name ||
                          channel == channels::Disparity::name ||
                          channel == channels::Odometry::name || channel == channels::Pose::name;
    if (streamed && silent_us > kInputMissing_us) {
      return {Health::kWaiting, "no " + channel + " for " +
                                    std::to_string(silent_us / kMicrosecondsPerSecond) + " s"};
    }
  }
  return {health_, health_reason_};
}

void Node::publish_status() {
  process_status_t status{};
  status.process = process_;
  status.pid = ::getpid();
  status.types_hash = types_hash();
  const auto [health, reason] = observed_health();
  status.health = static_cast<std::int8_t>(health);
  status.reason = reason;
  status.uptime_us = clock_.now_us() - started_us_;
  status.work_p50_us = work_.percentile_us(0.5);
  status.work_p99_us = work_.percentile_us(0.99);
  status.cpu_s = cpu_seconds();
  status.rss_bytes = resident_bytes();
  for (const auto& [channel, counts] : counts_)
    status.channels.push_back(to_message(channel, counts));
  status.channel_count = static_cast<std::int32_t>(status.channels.size());
  for (const auto& [name, value] : counters_) {
    counter_t counter{};
    counter.name = name;
    counter.value = value;
    status.counters.push_back(counter);
  }
  status.counter_count = static_cast<std::int32_t>(status.counters.size());
  publish<channels::ProcessStatus>(std::move(status), data_time_);
}

void Node::take_in(const RawMessage& raw) {
  if (on_raw_) guarded(raw.channel, [&] { on_raw_(raw); });
  const auto inbox = inboxes_.find(raw.channel);
  if (inbox == inboxes_.end()) return;
  guarded(raw.channel, [&] {
    if (auto accepted = inbox->second.accept(raw); !accepted)
      refuse(raw.channel, accepted.error().message);
  });
}

// A handler that throws (out of memory, a bug in a library) costs the message that it was handling,
// never the process.
void Node::guarded(std::string_view channel, const std::function<void()>& act) {
  try {
    act();
  } catch (const std::exception& problem) {
    refuse(channel, std::string("while handling it: ") + problem.what());
  }
}

void Node::run_host_timers() {
  for (std::size_t i = 0; i < host_timers_.size(); ++i) {
    const HostTime now_us = clock_.now_us();
    if (host_timers_[i].due_us > now_us) continue;
    // Missed periods are not made up for.
    const std::int64_t period_us = host_timers_[i].period_us;
    host_timers_[i].due_us += period_us * (1 + (now_us - host_timers_[i].due_us) / period_us);
    guarded("timer", host_timers_[i].act);
  }
}

void Node::run_data_timers() {
  for (std::size_t i = 0; i < data_timers_.size(); ++i) {
    Timer& timer = data_timers_[i];
    if (timer.due_us == 0) {
      timer.due_us = data_time_ + timer.period_us;
    } else if (timer.due_us <= data_time_) {
      timer.due_us += timer.period_us * (1 + (data_time_ - timer.due_us) / timer.period_us);
      guarded("timer", timer.act);
    }
  }
}

HostTime Node::next_deadline_us() const {
  HostTime next = host_timers_.front().due_us;
  for (const Timer& timer : host_timers_) next = std::min(next, timer.due_us);
  return next;
}

void Node::do_one() {
  if (pending_.empty()) return;
  Work work = std::move(pending_.front());
  pending_.pop_front();
  const HostTime start_us = clock_.now_us();
  // A time of sending may be forged; the difference must not overflow.
  counts_.find(work.inbox->channel)
      ->second.latency.add(start_us - std::max<HostTime>(0, work.sent_us));
  guarded(work.inbox->channel, work.act);
  // Ticks are no work; they would hide what the work takes.
  if (work.inbox->channel != channels::Clock::name) work_.add(clock_.now_us() - start_us);
}

void Node::spin_once(std::int64_t timeout_us) {
  const std::int64_t until_timer_us =
      std::max<std::int64_t>(0, next_deadline_us() - clock_.now_us());
  arrived_.clear();
  bus_.receive(has_work() ? 0 : std::min(timeout_us, until_timer_us), arrived_);
  for (const RawMessage& raw : arrived_) take_in(raw);
  run_host_timers();
  do_one();
  if (bus_.ended() && !has_work()) request_stop();
}

}  // namespace cairn::bus
