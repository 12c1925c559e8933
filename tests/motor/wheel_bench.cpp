// SPDX-License-Identifier: Apache-2.0
#include "wheel_bench.hpp"

#include <sys/resource.h>
#include <sys/timerfd.h>
#include <unistd.h>

#include <algorithm>
#include <random>

namespace cairn::testing {
namespace {

constexpr std::int64_t kLook_us = 1'000;
constexpr std::int64_t kIntake_us = 10'000;

/// Bytes wait until 10 ms are over since the last were taken.
class LateLine : public motor::ByteLink {
 public:
  LateLine(std::unique_ptr<motor::ByteLink> line, const bus::HostClock& clock)
      : line_{std::move(line)}, clock_{clock} {}
  [[nodiscard]] Result<std::vector<std::uint8_t>> read() override {
    if (clock_.now_us() - taken_us_ < kIntake_us) return std::vector<std::uint8_t>{};
    taken_us_ = clock_.now_us();
    return line_->read();
  }
  [[nodiscard]] Result<void> write(std::span<const std::uint8_t> bytes) override {
    return line_->write(bytes);
  }

 private:
  std::unique_ptr<motor::ByteLink> line_;
  const bus::HostClock& clock_;
  HostTime taken_us_ = 0;
};

}  // namespace

WheelBench::WheelBench(const std::filesystem::path& device)
    : rig_{std::make_unique<LateLine>(simulation::PseudoTerminal::open(device).value(), clock_),
           std::random_device{}(), clock_.now_us()},
      thread_{[this](const std::stop_token& stop) { run(stop); }} {}

WheelBench::~WheelBench() {
  thread_.request_stop();
  thread_.join();
}

// The instrument must not be what is late; where the machine does not allow it, the gap tells.
void WheelBench::run(const std::stop_token& stop) {
  (void)::setpriority(PRIO_PROCESS, static_cast<id_t>(::gettid()), -15);
  const int timer = ::timerfd_create(CLOCK_MONOTONIC, TFD_CLOEXEC);
  itimerspec period{};
  period.it_value.tv_nsec = period.it_interval.tv_nsec = kLook_us * 1000;
  ::timerfd_settime(timer, 0, &period, nullptr);
  HostTime looked_us = clock_.now_us();
  std::uint64_t ticks = 0;
  while (!stop.stop_requested() && ::read(timer, &ticks, sizeof ticks) == sizeof ticks) {
    const HostTime now_us = clock_.now_us();
    longest_gap_us_ = std::max(longest_gap_us_.load(), now_us - looked_us);
    looked_us = now_us;
    rig_.run(now_us);
    driven_ = rig_.driven();
    if (driven_) last_driven_us_ = now_us;
    speed_mps_ = (rig_.left.speed_mps + rig_.right.speed_mps) / 2;
  }
  ::close(timer);
}

}  // namespace cairn::testing
