// SPDX-License-Identifier: Apache-2.0
#include "odometry/made_tracks.hpp"

#include <cmath>

namespace cairn::testing {
namespace {

constexpr Utime kPeriod_us = 20'000;
constexpr double kTicksPerM = 5000;

}  // namespace

odometry::TrackReading MadeTracks::reading(Utime utime) const {
  const auto now = way_(to_seconds(utime));
  const auto before = way_(to_seconds(utime - kPeriod_us));
  odometry::TrackReading reading;
  reading.utime = utime;
  reading.left_ticks = std::llround(kTicksPerM * now.left_m);
  reading.right_ticks = std::llround(kTicksPerM * now.right_m);
  reading.ticks_per_m = kTicksPerM;
  reading.left_mps = (now.left_m - before.left_m) / to_seconds(kPeriod_us);
  reading.right_mps = (now.right_m - before.right_m) / to_seconds(kPeriod_us);
  return reading;
}

std::optional<odometry::TrackHistory::Moment> MadeTracks::at(Utime utime) {
  const Utime until = utime - odometry::TrackHistory::kLag_us;
  if (next_ == 0) next_ = std::max<Utime>(kPeriod_us, until - until % kPeriod_us);
  for (; next_ <= until; next_ += kPeriod_us) history_.add(reading(next_));
  return history_.at(utime);
}

MadeTracks::Way steady_tracks(double speed_mps, double turn_radps, double left_slip,
                              double right_slip) {
  const double half_gauge_m = RobotConfig{}.track_gauge_m / 2;
  const double left_mps = (speed_mps - turn_radps * half_gauge_m) * (1 + left_slip);
  const double right_mps = (speed_mps + turn_radps * half_gauge_m) * (1 + right_slip);
  return [=](double seconds) {
    return odometry::TrackWay{left_mps * seconds, right_mps * seconds};
  };
}

}  // namespace cairn::testing
