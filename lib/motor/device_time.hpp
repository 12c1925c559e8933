// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <deque>
#include <optional>

#include "core/time.hpp"

namespace cairn::motor {

/// Maps a wheel controller's clock to data time. Data time goes on between two CLOCKs at the rate
/// that they name.
///
/// The difference of the two clocks is one number but for the crystals' drift. What is measured of
/// it is too large by a reading's way over the line and by what data time is thought to have gone
/// on while its sender waited, and too small, now and then, by a CLOCK that was late. So the
/// smallest are the truest, but for a few: what an eighth of the last 5 s are not over is taken.
/// Stamps made with it are as even as the controller's clock.
class DeviceTime {
 public:
  static constexpr std::int64_t kWindow_us = 5'000'000;      ///< of device time
  static constexpr std::size_t kMaxReadings = 512;           ///< of the window, the newest
  static constexpr std::int64_t kMaxExtension_us = 100'000;  ///< of host time, beyond a CLOCK
  static constexpr std::int64_t kJump_us = 500'000;          ///< of data time: a new beginning

  /// What a CLOCK says.
  void tick(Utime utime, double rate, HostTime sent_us);

  /// 0 before the first CLOCK.
  [[nodiscard]] Utime data_now(HostTime now_us) const;

  /// The data time of a reading that has just come, later than that of the reading before unless
  /// data time was set back; 0 before the first CLOCK. Device time rises from call to call.
  [[nodiscard]] Utime stamp(std::int64_t device_us, HostTime now_us);

  /// The controller started anew, and its clock with it.
  void restart() { differences_.clear(); }

 private:
  struct Tick {
    Utime utime;
    double rate;
    HostTime sent_us;
  };
  struct Difference {
    std::int64_t device_us;
    std::int64_t data_minus_device_us;
  };
  void learn(std::int64_t device_us, HostTime now_us);
  [[nodiscard]] std::int64_t data_minus_device_us() const;

  std::optional<Tick> tick_;
  std::deque<Difference> differences_;  ///< rising in device time
  Utime last_stamp_ = 0;
};

}  // namespace cairn::motor
