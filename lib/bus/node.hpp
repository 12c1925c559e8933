// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cairn/header_t.hpp>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "bus/bus.hpp"
#include "bus/channels.hpp"
#include "bus/codec.hpp"
#include "bus/host_clock.hpp"
#include "bus/join.hpp"
#include "bus/statistics.hpp"
#include "core/result.hpp"
#include "core/state_folder.hpp"
#include "core/time.hpp"

namespace cairn::bus {

enum class Level { kDebug = 0, kInfo = 1, kWarning = 2, kError = 3 };
enum class Health { kStarting = 0, kOk = 1, kWaiting = 2, kIll = 3 };

/// What one process counted on one channel.
struct ChannelCounts {
  std::int64_t received = 0;  ///< whole and accepted
  std::int64_t published = 0;
  std::int64_t lost = 0;     ///< gaps in the senders' sequences
  std::int64_t skipped = 0;  ///< dropped for a newer one
  std::int64_t refused = 0;  ///< bad bytes or bad content
  std::string last_refusal;
  DurationStatistics latency;  ///< from sending to handling
};

/// The runtime of one process: typed messages in and out, joins, timers of both clocks, counting,
/// heartbeat. It does all its work in `spin_once`, on one thread; no handler is ever run from
/// another. The same class runs live, on a recording and in lockstep; only its Bus and HostClock
/// differ.
class Node {
 public:
  /// `session` tells this run of the process from its other runs (DESIGN rule 5).
  Node(std::string process, Bus& bus, const HostClock& clock, StateFolder state,
       std::int64_t session);

  // ---- wiring; before the first spin ----

  /// Calls `handle(message)` for every message of the channel that is whole, as the channel's
  /// backlog allows.
  template <class Channel>
  void on(std::function<void(const typename Channel::type&)> handle) {
    Inbox& inbox = open_inbox(Channel::name, Channel::backlog);
    inbox.accept = [this, &inbox,
                    handle = std::move(handle)](const RawMessage& raw) -> Result<void> {
      auto decoded = decode<typename Channel::type>(raw.bytes);
      if (!decoded) return tl::make_unexpected(decoded.error());
      count_arrival(inbox, decoded->header);
      auto message = std::make_shared<const typename Channel::type>(std::move(*decoded));
      enqueue(
          inbox, [handle, message] { handle(*message); }, message->header.sent_steady_us);
      return {};
    };
  }

  /// Calls `handle(a, b)` for each utime of which both channels have brought a message, in rising
  /// order of utime, whatever the order of arrival. Where pairs come faster than they are handled,
  /// all but the newest `backlog` are skipped and counted on channel A.
  template <class A, class B>
  void join(std::function<void(const typename A::type&, const typename B::type&)> handle,
            Backlog backlog = Backlog::kFew) {
    auto pairs = std::make_shared<Join<typename A::type, typename B::type>>();
    Inbox& a = open_inbox(A::name, backlog);
    Inbox& b = open_inbox(B::name, backlog);
    const auto enqueue_pairs = [this, pairs, &a, handle] {
      while (auto pair = pairs->take()) {
        auto both = std::make_shared<decltype(pair)>(std::move(pair));
        enqueue(
            a, [handle, both] { handle((*both)->first, (*both)->second); },
            (*both)->first.header.sent_steady_us);
      }
    };
    a.accept = [this, pairs, &a, enqueue_pairs](const RawMessage& raw) -> Result<void> {
      auto decoded = decode<typename A::type>(raw.bytes);
      if (!decoded) return tl::make_unexpected(decoded.error());
      count_arrival(a, decoded->header);
      pairs->put_first(std::move(*decoded));
      enqueue_pairs();
      return {};
    };
    b.accept = [this, pairs, &b, enqueue_pairs](const RawMessage& raw) -> Result<void> {
      auto decoded = decode<typename B::type>(raw.bytes);
      if (!decoded) return tl::make_unexpected(decoded.error());
      count_arrival(b, decoded->header);
      pairs->put_second(std::move(*decoded));
      enqueue_pairs();
      return {};
    };
  }

  /// Every message of every channel, undecoded; for recorders and spies.
  void on_raw(std::function<void(const RawMessage&)> handle);

  /// A timer of host time: heartbeats, pacing. First due one period from now.
  void every_host(std::int64_t period_us, std::function<void()> act);

  /// A timer of data time, which CLOCK moves: first due one period after the first CLOCK.
  void every_data(std::int64_t period_us, std::function<void()> act);

  // ---- in handlers and timers ----

  /// Sends `message` with its header filled in: `utime` is the data time of what it rests on. False
  /// if it could not be sent; the reason is logged and counted.
  template <class Channel>
  bool publish(typename Channel::type message, Utime utime) {
    message.header = next_header(Channel::name, utime);
    const auto bytes = encode(message);
    if (!bytes) return count_unsent(Channel::name, bytes.error());
    return send(Channel::name, *bytes);
  }

  /// What it just got on this channel is no good: counted where people see it, and logged now and
  /// then.
  void refuse(std::string_view channel, const std::string& reason);

  /// A number of the process's own, shown in PROCESS_STATUS.
  std::int64_t& counter(const std::string& name) { return counters_[name]; }

  /// Printed, and sent as LOG_LINE.
  void log(Level level, const std::string& text);

  /// How the process says it is; overridden by what the runtime sees (inputs missing).
  void set_health(Health health, const std::string& reason);

  /// Data time: of the newest CLOCK; 0 before the first. Whoever sends CLOCK says it itself.
  [[nodiscard]] Utime data_time() const { return data_time_; }
  void set_data_time(Utime utime);

  [[nodiscard]] HostTime host_time() const { return clock_.now_us(); }
  [[nodiscard]] const StateFolder& state() const { return state_; }
  [[nodiscard]] const std::string& process() const { return process_; }

  /// The run loop ends after this piece of work.
  void request_stop() { stopping_ = true; }
  [[nodiscard]] bool stopping() const { return stopping_; }

  // ---- run loop ----

  /// Takes in all that has arrived, runs the timers that are due, then does at most one piece of
  /// work. Waits for something to do, at most `timeout_us`.
  void spin_once(std::int64_t timeout_us);

  /// Sends PROCESS_STATUS now; otherwise it goes out with the first spin and once a second.
  void publish_status();

  /// True if messages that were taken in still wait to be handled.
  [[nodiscard]] bool has_work() const { return !pending_.empty(); }
  /// When the next timer of host time is due.
  [[nodiscard]] HostTime next_deadline_us() const;
  [[nodiscard]] const std::map<std::string, ChannelCounts, std::less<>>& counts() const {
    return counts_;
  }
  /// The state of a channel that could not be subscribed to, else nothing.
  [[nodiscard]] const Result<void>& wiring() const { return wiring_; }

 private:
  struct Inbox {
    std::string channel;
    std::size_t backlog;
    std::function<Result<void>(const RawMessage&)> accept;
    HostTime last_received_us = 0;
    std::map<std::int64_t, std::int32_t> last_sequence;  ///< by session
  };
  struct Work {
    Inbox* inbox;
    std::function<void()> act;
    HostTime sent_us;
  };
  struct Timer {
    std::int64_t period_us;
    std::int64_t due_us;  ///< 0: not started yet
    std::function<void()> act;
  };

  Inbox& open_inbox(const char* channel, Backlog backlog);
  void count_arrival(Inbox& inbox, const header_t& header);
  void enqueue(Inbox& inbox, std::function<void()> act, HostTime sent_us);
  header_t next_header(const char* channel, Utime utime);
  bool send(const char* channel, const std::vector<std::uint8_t>& bytes);
  bool count_unsent(const char* channel, const Error& error);
  void take_in(const RawMessage& raw);
  void run_host_timers();
  void run_data_timers();
  void do_one();
  void guarded(std::string_view channel, const std::function<void()>& act);
  [[nodiscard]] std::pair<Health, std::string> observed_health() const;

  std::string process_;
  Bus& bus_;
  const HostClock& clock_;
  StateFolder state_;
  std::int64_t session_;
  HostTime started_us_;
  Result<void> wiring_;
  std::map<std::string, Inbox, std::less<>> inboxes_;
  std::function<void(const RawMessage&)> on_raw_;
  std::deque<Work> pending_;
  std::vector<Timer> host_timers_;
  std::vector<Timer> data_timers_;
  std::map<std::string, std::int32_t, std::less<>> next_sequence_;
  std::map<std::string, ChannelCounts, std::less<>> counts_;
  std::map<std::string, std::int64_t> counters_;
  DurationStatistics work_;
  Utime data_time_ = 0;
  Health health_ = Health::kOk;
  std::string health_reason_;
  bool stopping_ = false;
  std::vector<RawMessage> arrived_;
};

}  // namespace cairn::bus
