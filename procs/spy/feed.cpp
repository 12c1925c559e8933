// SPDX-License-Identifier: Apache-2.0
#include "procs/spy/feed.hpp"

#include <csignal>

namespace cairn::spy {
namespace {

/// How long the end of the program may go unnoticed while nothing arrives.
constexpr std::int64_t kLongestWait_us = 50'000;

/// Signals are for the thread that has the terminal.
void take_no_signals() {
  sigset_t all;
  sigfillset(&all);
  ::pthread_sigmask(SIG_BLOCK, &all, nullptr);
}

}  // namespace

LiveFeed::LiveFeed(const Schema& schema, std::unique_ptr<bus::Bus> bus, PaceWindow window)
    : bus_{std::move(bus)},
      traffic_{schema, window, Timing::kLive},
      thread_{[this](const std::stop_token& stop) { listen(stop); }} {}

void LiveFeed::listen(const std::stop_token& stop) {
  take_no_signals();
  std::vector<bus::RawMessage> arrived;
  while (!stop.stop_requested()) {
    arrived.clear();
    bus_->receive(kLongestWait_us, arrived);
    const std::scoped_lock lock(mutex_);
    const HostTime now_us = clock_.now_us();
    for (bus::RawMessage& message : arrived) traffic_.add(std::move(message), now_us);
  }
}

Snapshot LiveFeed::snapshot() {
  const std::scoped_lock lock(mutex_);
  return {traffic_.summary(clock_.now_us()), traffic_.newest(), std::nullopt, 0};
}

RecordedFeed::RecordedFeed(const Schema& schema, bus::RecordingReader reader, PaceWindow window)
    : schema_{schema},
      reader_{std::move(reader)},
      window_{window},
      traffic_{schema, window, Timing::kRecorded},
      thread_{[this](const std::stop_token& stop) { read(stop); }} {}

void RecordedFeed::begin_anew() {
  reader_.rewind();
  traffic_ = Traffic(schema_, window_, Timing::kRecorded);
  anew_ = false;
}

void RecordedFeed::read(const std::stop_token& stop) {
  take_no_signals();
  while (true) {
    {
      std::unique_lock lock(mutex_);
      if (!wake_.wait(lock, stop, [this] { return running_; })) return;
      if (anew_) begin_anew();
    }
    auto event = reader_.next();
    const std::scoped_lock lock(mutex_);
    damage_ = {reader_.damaged_places(), reader_.damaged_bytes(), reader_.damage()};
    progress_ =
        static_cast<double>(reader_.position_bytes()) / static_cast<double>(reader_.size_bytes());
    if (event) {
      traffic_.add(std::move(event->message), event->recorded_us);
    } else {
      ended_ = true;
      running_ = false;
    }
    if (stop.stop_requested()) return;
  }
}

void RecordedFeed::set_running(bool running) {
  const std::scoped_lock lock(mutex_);
  running_ = running;
  if (running && ended_) {
    anew_ = true;
    ended_ = false;
  }
  wake_.notify_all();
}

Snapshot RecordedFeed::snapshot() {
  const std::scoped_lock lock(mutex_);
  return {traffic_.summary(traffic_.last_us()), traffic_.newest(), damage_, progress_};
}

}  // namespace cairn::spy
