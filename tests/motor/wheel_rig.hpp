// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "core/time.hpp"
#include "motor/byte_link.hpp"
#include "simulation/wheel_controller.hpp"

namespace cairn::testing {

/// A track that follows its duty as a first-order lag.
struct Plant {
  double full_duty_mps = 0.8;
  double lag_s = 0.15;
  double ticks_per_m = 5000;
  double speed_mps = 0;
  double way_m = 0;
  bool blocked = false;

  void run(double duty, double dt_s) {
    const double goal_mps = blocked ? 0 : duty * full_duty_mps;
    const double before_mps = speed_mps;
    speed_mps = blocked ? 0 : goal_mps + (speed_mps - goal_mps) * std::exp(-dt_s / lag_s);
    way_m += dt_s * (before_mps + speed_mps) / 2;
  }
  [[nodiscard]] std::int64_t ticks() const {
    return static_cast<std::int64_t>(std::floor(way_m * ticks_per_m));
  }
};

/// The reference controller with two tracks, at the far end of a line.
class WheelRig {
 public:
  WheelRig(std::unique_ptr<motor::ByteLink> line, std::uint32_t session, HostTime now_us)
      : line_{std::move(line)}, controller_{session}, started_us_{now_us}, now_us_{now_us} {}

  /// Goes on to `now_us`; bytes that came count from then on.
  void run(HostTime now_us) {
    if (auto bytes = line_->read()) {
      heard_.insert(heard_.end(), bytes->begin(), bytes->end());
      controller_.receive(*bytes, now_us);
    }
    const auto duty = controller_.duty(now_us);
    const double dt_s = to_seconds(now_us - now_us_);
    left.run(duty.left, dt_s);
    right.run(duty.right, dt_s);
    now_us_ = now_us;
    if (now_us - started_us_ < next_report_us_ || silent) return;
    next_report_us_ += simulation::WheelController::kReportPeriod_us;
    const auto report =
        controller_.report(left.ticks(), right.ticks(), now_us - started_us_, now_us);
    if (!line_->write(report.bytes())) ++unsent;
  }

  [[nodiscard]] simulation::WheelController::Duty duty() const { return controller_.duty(now_us_); }
  [[nodiscard]] bool driven() const { return duty().left != 0 || duty().right != 0; }
  [[nodiscard]] simulation::WheelController& controller() { return controller_; }
  /// All bytes that came since the last call.
  [[nodiscard]] std::vector<std::uint8_t> heard() { return std::exchange(heard_, {}); }

  Plant left;
  Plant right;
  bool silent = false;
  int unsent = 0;

 private:
  std::unique_ptr<motor::ByteLink> line_;
  simulation::WheelController controller_;
  HostTime started_us_;
  HostTime now_us_;
  std::int64_t next_report_us_ = 0;
  std::vector<std::uint8_t> heard_;
};

}  // namespace cairn::testing
