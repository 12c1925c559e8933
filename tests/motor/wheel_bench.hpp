// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "bus/host_clock.hpp"
#include "core/time.hpp"
#include "simulation/pseudo_terminal.hpp"
#include "wheel_rig.hpp"

namespace cairn::testing {

/// A wheel controller with two tracks behind a pseudo-terminal, on a thread of its own, as
/// hardware is. It takes bytes in every 10 ms only, as late as a simulator that paints may.
class WheelBench {
 public:
  explicit WheelBench(const std::filesystem::path& device);
  WheelBench(const WheelBench&) = delete;
  WheelBench& operator=(const WheelBench&) = delete;
  ~WheelBench();

  /// The drivers get something other than zero now.
  [[nodiscard]] bool driven() const { return driven_; }
  /// When they did last; 0: never.
  [[nodiscard]] HostTime last_driven_us() const { return last_driven_us_; }
  [[nodiscard]] double speed_mps() const { return speed_mps_; }
  /// The longest time between two looks of this bench: what a measurement may be off by.
  [[nodiscard]] std::int64_t longest_gap_us() const { return longest_gap_us_; }

 private:
  void run(const std::stop_token& stop);

  bus::SteadyClock clock_;
  WheelRig rig_;
  std::atomic<bool> driven_ = false;
  std::atomic<HostTime> last_driven_us_ = 0;
  std::atomic<double> speed_mps_ = 0;
  std::atomic<std::int64_t> longest_gap_us_ = 0;
  std::jthread thread_;
};

}  // namespace cairn::testing
