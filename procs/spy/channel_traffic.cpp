// SPDX-License-Identifier: Apache-2.0
#include "procs/spy/channel_traffic.hpp"

#include <algorithm>
#include <cstdio>

#include "bus/codec.hpp"
#include "core/time.hpp"
#include "procs/spy/field_tree.hpp"
#include "procs/spy/saturating.hpp"
#include "procs/spy/succession.hpp"
#include "procs/spy/wire_reader.hpp"

namespace cairn::spy {
namespace {

constexpr std::size_t kFingerprintSize = 8;
constexpr std::size_t kMostSessions = 256;
/// What claims to have been under way for longer was not sent live on this machine.
constexpr std::int64_t kLongestLatency_us = 10 * kMicrosecondsPerSecond;
constexpr double kStalePeriods = 5;
constexpr double kShortestStale_us = 500'000;

bool has_header(const MessageType& type) {
  return !type.fields.empty() && type.fields.front().type == "header_t";
}

std::string unknown_type(std::uint64_t fingerprint) {
  char text[40];
  std::snprintf(text, sizeof(text), "unknown 0x%016llx",
                static_cast<unsigned long long>(fingerprint));
  return text;
}

}  // namespace

ChannelTraffic::ChannelTraffic(const Schema& schema, std::string channel, PaceWindow window,
                               Timing timing)
    : schema_{schema},
      channel_{std::move(channel)},
      entry_{catalogue_entry(channel_)},
      timing_{timing},
      type_{entry_ == nullptr ? "unknown" : entry_->type},
      pace_{window} {}

Result<const MessageType*> ChannelTraffic::recognise(const std::vector<std::uint8_t>& bytes) {
  const auto fingerprint = WireReader(bytes).unsigned_integer(kFingerprintSize);
  if (!fingerprint) return fail("too short for a message");
  const MessageType* const said = schema_.find(*fingerprint);
  if (entry_ == nullptr) {
    type_ = said == nullptr ? unknown_type(*fingerprint) : said->name;
    if (said == nullptr) return fail("no known type has this fingerprint");
  }
  const MessageType* const type = entry_ == nullptr ? said : schema_.find(entry_->type);
  if (type == nullptr) return fail("there is no type " + entry_->type);
  if (type->fingerprint != *fingerprint) {
    return fail(said == nullptr ? "another version of " + type->name + ", or none at all"
                                : "a " + said->name + " on a channel of " + type->name);
  }
  if (auto whole = check_message(schema_, *type, bytes); !whole)
    return tl::make_unexpected(whole.error());
  return type;
}

Result<void> ChannelTraffic::take_header(const std::vector<std::uint8_t>& bytes,
                                         std::int64_t time_us) {
  const auto header = bus::peek_header(bytes);
  if (!header) return tl::make_unexpected(header.error());
  if (header->utime < 0) return fail("header.utime is negative");
  if (header->sequence < 0) return fail("header.sequence is negative");
  Session& from = session(header->session, header->sequence, time_us);
  const std::int64_t step = std::int64_t{header->sequence} - from.last_sequence;
  const std::int64_t missing = from.count > 0 ? std::max<std::int64_t>(0, step - 1) : 0;
  from.lost += missing;
  lost_ += missing;
  if (from.count > 0 && step < 1) ++out_of_order_;
  from.last_sequence = header->sequence;
  from.last_us = time_us;
  ++from.count;
  const std::int64_t latency_us = saturating_difference(time_us, header->sent_steady_us);
  if (timing_ == Timing::kLive && latency_us >= 0 && latency_us <= kLongestLatency_us) {
    latency_.add(latency_us);
    latency_known_ = true;
  }
  return {};
}

ChannelTraffic::Session& ChannelTraffic::session(std::int64_t id, std::int32_t sequence,
                                                 std::int64_t time_us) {
  if (const auto known = sessions_.find(id); known != sessions_.end()) return known->second;
  if (sessions_.size() >= kMostSessions) {
    const auto heard_before = [](const auto& a, const auto& b) {
      return a.second.last_us < b.second.last_us;
    };
    sessions_.erase(std::min_element(sessions_.begin(), sessions_.end(), heard_before));
    ++forgotten_sessions_;
  }
  return sessions_.emplace(id, Session{sequence, 0, 0, time_us, time_us}).first->second;
}

void ChannelTraffic::add(std::vector<std::uint8_t> bytes, std::int64_t time_us) {
  ++count_;
  bytes_ += static_cast<std::int64_t>(bytes.size());
  pace_.add(time_us, bytes.size());
  last_us_ = time_us;
  auto type = recognise(bytes);
  if (type && has_header(**type)) {
    if (auto taken = take_header(bytes, time_us); !taken) type = tl::make_unexpected(taken.error());
  }
  if (!type) {
    ++undecodable_;
    last_problem_ = type.error().message;
    return;
  }
  newest_ = {*type, std::make_shared<const std::vector<std::uint8_t>>(std::move(bytes))};
}

bool ChannelTraffic::stale(std::int64_t age_us, const std::optional<Pace>& pace) const {
  if (entry_ == nullptr || !entry_->steady || !pace) return false;
  return static_cast<double>(age_us) >
         std::max(kShortestStale_us, kStalePeriods * pace->mean_interval_us);
}

ChannelSummary ChannelTraffic::summary(std::int64_t now_us, const NameOfSession& name_of) const {
  ChannelSummary summary;
  summary.channel = channel_;
  summary.type = type_;
  summary.in_catalogue = entry_ != nullptr;
  summary.count = count_;
  summary.bytes = bytes_;
  summary.pace = pace_.pace(now_us);
  summary.lost = lost_;
  summary.out_of_order = out_of_order_;
  summary.undecodable = undecodable_;
  summary.last_problem = last_problem_;
  summary.age_us = age(now_us, last_us_);
  summary.stale = stale(summary.age_us, summary.pace);
  if (latency_known_)
    summary.latency = Latency{latency_.percentile_us(0.5), latency_.percentile_us(0.99)};
  std::vector<HeardRun> runs;
  for (const auto& [id, session] : sessions_) {
    const std::string process = name_of(id);
    runs.push_back({process, session.first_us, session.last_us});
    summary.senders.push_back(
        {id, process, session.count, session.lost, age(now_us, session.last_us)});
  }
  summary.restarts = forgotten_sessions_ + restarts_in(std::move(runs));
  std::stable_sort(
      summary.senders.begin(), summary.senders.end(),
      [](const SenderSummary& a, const SenderSummary& b) { return a.age_us < b.age_us; });
  return summary;
}

}  // namespace cairn::spy
