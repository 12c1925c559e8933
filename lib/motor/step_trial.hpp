// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <string>
#include <vector>

#include "core/time.hpp"
#include "motor/step_response.hpp"
#include "motor/wheel_line.hpp"

namespace cairn::motor {

/// Drives one track after the other with a step of duty, and looks what it does: for a robot whose
/// tracks are off the ground. Knows no gate. Host time is passed in.
class StepTrial {
 public:
  static constexpr double kDuty = 0.4;
  static constexpr std::int64_t kTick_us = 5'000;
  static constexpr std::int64_t kStep_us = 1'500'000;      ///< of the controller's time
  static constexpr std::int64_t kRest_us = 1'000'000;      ///< before each step
  static constexpr std::int64_t kPatience_us = 5'000'000;  ///< for a controller

  StepTrial(WheelLine line, double ticks_per_m, HostTime now_us)
      : line_{std::move(line)}, ticks_per_m_{ticks_per_m}, began_us_{now_us} {}

  /// To be called every kTick_us, as long as it is true. A controller that is lost ends it.
  [[nodiscard]] bool tick(HostTime now_us);

  /// Zero, now and for good.
  void stop();

  /// Of the left and the right track, once `tick` is false; or what went wrong.
  [[nodiscard]] Result<std::array<StepFit, 2>> result() const;

 private:
  void take(const ReportFrame& report);
  void end(const std::string& problem);

  WheelLine line_;
  double ticks_per_m_;
  HostTime began_us_;
  bool seen_ = false;
  bool done_ = false;
  std::string problem_;
  std::size_t track_ = 0;  ///< 0 left, 1 right
  bool stepping_ = false;
  std::int64_t since_us_ = 0;  ///< of the controller's time: this step or rest
  bool any_ = false;
  std::array<std::int64_t, 2> from_ticks_{};
  std::array<std::array<std::vector<StepPoint>, 2>, 2> points_;  ///< by the step, then the track
};

}  // namespace cairn::motor
