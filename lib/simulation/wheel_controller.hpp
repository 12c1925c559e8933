// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>

#include "motor/wheel_protocol.hpp"

namespace cairn::simulation {

/// The reference firmware of a wheel controller: what lies between the serial line, the two motor
/// drivers and the two encoders. Without heap, exceptions or input and output of its own, so that a
/// microcontroller runs it as the simulator does. Its owner passes in the time: on hardware
/// `host_us` and `device_us` are one clock; in a simulation that runs at another speed than life,
/// `device_us` is the simulated time and `host_us` the time that commands age by.
class WheelController {
 public:
  struct Duty {
    double left = 0;   ///< share of full drive, -1 to 1
    double right = 0;  ///< share of full drive, -1 to 1
  };

  static constexpr std::int64_t kWatchdog_us = 200'000;
  static constexpr std::int64_t kReportPeriod_us = 20'000;  ///< of device time
  static constexpr std::uint16_t kFirmware = 0x0100;        ///< 1.0

  /// `session` tells this start from others.
  explicit WheelController(std::uint32_t session) : session_{session} {}

  /// Bytes from the line, in any portions.
  void receive(std::span<const std::uint8_t> bytes, std::int64_t host_us);

  /// The report to send now; due every kReportPeriod_us.
  [[nodiscard]] motor::WireFrame report(std::int64_t left_ticks, std::int64_t right_ticks,
                                        std::int64_t device_us, std::int64_t host_us) const;

  /// What the motor drivers are to be given now: 0 once there was no good new command for 200 ms.
  [[nodiscard]] Duty duty(std::int64_t host_us) const;

  void set_low_battery(bool low) { low_battery_ = low; }
  [[nodiscard]] const motor::LineCounts& line() const { return parser_.counts(); }
  /// Whole commands that were not obeyed because their number had not risen.
  [[nodiscard]] std::int64_t refused() const { return refused_; }

 private:
  void obey(const motor::DriveFrame& command, std::int64_t host_us);
  [[nodiscard]] bool starved(std::int64_t host_us) const;

  std::uint32_t session_;
  motor::FrameParser parser_;
  Duty duty_;
  std::uint32_t last_number_ = 0;
  bool commanded_ = false;  ///< since its start
  std::int64_t obeyed_us_ = 0;
  std::int64_t refused_ = 0;
  bool low_battery_ = false;
};

}  // namespace cairn::simulation
