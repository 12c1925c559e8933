// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "bus/bus.hpp"
#include "bus/host_clock.hpp"
#include "bus/recording.hpp"
#include "procs/spy/traffic.hpp"

namespace cairn::spy {

struct Damage {
  int places = 0;
  std::uint64_t bytes = 0;
  std::string text;  ///< empty where there is none
};

/// What a feed had at one moment.
struct Snapshot {
  TrafficSummary traffic;
  std::map<std::string, NewestMessage, std::less<>> newest;  ///< by channel
  std::optional<Damage> damage;                              ///< of a recording
  double progress = 0;                                       ///< share of a recording that is read
};

/// Hears messages on a thread of its own and counts them, so that a slow terminal costs none.
class Feed {
 public:
  virtual ~Feed() = default;
  [[nodiscard]] virtual Snapshot snapshot() = 0;
  /// Whether nothing more will come.
  [[nodiscard]] virtual bool ended() const = 0;
  /// Stops and starts the reading of a recording, at its end from the beginning; what is live goes
  /// on.
  virtual void set_running(bool running) = 0;
};

class LiveFeed : public Feed {
 public:
  /// The bus must be subscribed to everything.
  LiveFeed(const Schema& schema, std::unique_ptr<bus::Bus> bus, PaceWindow window);

  Snapshot snapshot() override;
  [[nodiscard]] bool ended() const override { return false; }
  void set_running(bool) override {}

 private:
  void listen(const std::stop_token& stop);

  std::unique_ptr<bus::Bus> bus_;
  bus::SteadyClock clock_;
  std::mutex mutex_;
  Traffic traffic_;
  std::jthread thread_;
};

class RecordedFeed : public Feed {
 public:
  RecordedFeed(const Schema& schema, bus::RecordingReader reader, PaceWindow window);

  Snapshot snapshot() override;
  [[nodiscard]] bool ended() const override { return ended_; }
  void set_running(bool running) override;

 private:
  void read(const std::stop_token& stop);
  void begin_anew();

  const Schema& schema_;
  bus::RecordingReader reader_;
  PaceWindow window_;
  std::mutex mutex_;
  std::condition_variable_any wake_;
  Traffic traffic_;
  Damage damage_;
  double progress_ = 0;
  bool running_ = true;
  bool anew_ = false;
  std::atomic<bool> ended_ = false;
  std::jthread thread_;
};

}  // namespace cairn::spy
