// SPDX-License-Identifier: Apache-2.0
#include "procs/spy/traffic.hpp"

#include "bus/channels.hpp"
#include "bus/codec.hpp"
#include "core/time.hpp"
#include "procs/spy/saturating.hpp"

namespace cairn::spy {
namespace {

constexpr std::string_view kSelfTest = "LCM_SELF_TEST";
/// Names may be forged; the table of them must not grow without end.
constexpr std::size_t kMostChannels = 1000;

}  // namespace

void Traffic::add(bus::RawMessage message, std::int64_t time_us) {
  if (message.channel == kSelfTest) return;
  if (messages_ == 0) first_us_ = time_us;
  if (messages_ > 0 && age(last_us_, time_us) > kMicrosecondsPerSecond) ++time_set_back_;
  last_us_ = time_us;
  ++messages_;
  bytes_ += static_cast<std::int64_t>(message.bytes.size());
  auto channel = channels_.find(message.channel);
  if (channel == channels_.end()) {
    if (channels_.size() >= kMostChannels) {
      ++ignored_;
      return;
    }
    channel =
        channels_
            .emplace(message.channel, ChannelTraffic(*schema_, message.channel, window_, timing_))
            .first;
  }
  if (message.channel == bus::channels::ProcessStatus::name) {
    if (const auto status = bus::decode<process_status_t>(message.bytes))
      processes_.add(*status, time_us);
  }
  channel->second.add(std::move(message.bytes), time_us);
}

TrafficSummary Traffic::summary(std::int64_t now_us) const {
  TrafficSummary summary;
  summary.messages = messages_;
  summary.bytes = bytes_;
  summary.ignored = ignored_;
  summary.time_set_back = time_set_back_;
  if (messages_ > 0) summary.span_us = age(now_us, first_us_);
  const auto name_of = [this](std::int64_t session) { return processes_.name_of(session); };
  for (const auto& [name, channel] : channels_) {
    summary.channels.push_back(channel.summary(now_us, name_of));
    summary.lost += summary.channels.back().lost;
    summary.undecodable += summary.channels.back().undecodable;
  }
  summary.processes = processes_.summary(now_us);
  return summary;
}

std::map<std::string, NewestMessage, std::less<>> Traffic::newest() const {
  std::map<std::string, NewestMessage, std::less<>> messages;
  for (const auto& [name, channel] : channels_) {
    if (channel.newest().type != nullptr) messages.emplace(name, channel.newest());
  }
  return messages;
}

}  // namespace cairn::spy
