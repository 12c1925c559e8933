// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "bus/statistics.hpp"
#include "procs/spy/catalogue.hpp"
#include "procs/spy/lcm_schema.hpp"
#include "procs/spy/pace.hpp"
#include "procs/spy/summary.hpp"

namespace cairn::spy {

/// Whether messages arrive as they are sent, or come from a recording, where latency means nothing.
enum class Timing { kLive, kRecorded };

/// A whole message and its type; the type lives as long as its schema.
struct NewestMessage {
  const MessageType* type = nullptr;
  std::shared_ptr<const std::vector<std::uint8_t>> bytes;
};

/// Name of the process that a session belongs to; empty where not known.
using NameOfSession = std::function<std::string(std::int64_t session)>;

/// All that is counted on one channel.
class ChannelTraffic {
 public:
  ChannelTraffic(const Schema& schema, std::string channel, PaceWindow window, Timing timing);

  void add(std::vector<std::uint8_t> bytes, std::int64_t time_us);

  [[nodiscard]] ChannelSummary summary(std::int64_t now_us, const NameOfSession& name_of) const;

  /// The last whole message; its type is null before the first.
  [[nodiscard]] const NewestMessage& newest() const { return newest_; }

 private:
  struct Session {
    std::int32_t last_sequence = 0;
    std::int64_t count = 0;
    std::int64_t lost = 0;
    std::int64_t first_us = 0;
    std::int64_t last_us = 0;
  };
  /// The type that the bytes are of, if they are a whole message.
  [[nodiscard]] Result<const MessageType*> recognise(const std::vector<std::uint8_t>& bytes);
  [[nodiscard]] Result<void> take_header(const std::vector<std::uint8_t>& bytes,
                                         std::int64_t time_us);
  Session& session(std::int64_t id, std::int32_t sequence, std::int64_t time_us);
  [[nodiscard]] bool stale(std::int64_t age_us, const std::optional<Pace>& pace) const;

  const Schema& schema_;
  std::string channel_;
  const CatalogueEntry* entry_;
  Timing timing_;
  std::string type_;
  PaceMeter pace_;
  std::int64_t count_ = 0;
  std::int64_t bytes_ = 0;
  std::int64_t lost_ = 0;
  std::int64_t out_of_order_ = 0;
  std::int64_t undecodable_ = 0;
  std::string last_problem_;
  std::int64_t last_us_ = 0;
  bus::DurationStatistics latency_;
  bool latency_known_ = false;
  std::map<std::int64_t, Session> sessions_;
  int forgotten_sessions_ = 0;
  NewestMessage newest_;
};

}  // namespace cairn::spy
