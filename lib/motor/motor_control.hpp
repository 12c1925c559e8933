// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/robot.hpp"
#include "core/time.hpp"
#include "motor/command_gate.hpp"
#include "motor/device_time.hpp"
#include "motor/track.hpp"
#include "motor/track_pid.hpp"
#include "motor/wheel_line.hpp"

namespace cairn::motor {

/// Bits of WheelReading::faults.
inline constexpr std::int32_t kFaultNoController = 1;
inline constexpr std::int32_t kFaultStalledLeft = 2;
inline constexpr std::int32_t kFaultStalledRight = 4;
inline constexpr std::int32_t kFaultLowBattery = 8;

/// What the tracks do.
struct WheelReading {
  Utime utime = 0;
  std::int64_t left_ticks = 0;
  std::int64_t right_ticks = 0;
  double left_measured_mps = 0;
  double right_measured_mps = 0;
  double left_commanded_mps = 0;
  double right_commanded_mps = 0;
  std::int32_t faults = 0;
  GateState gate = GateState::kIdle;
};

/// All of a motor process but its bus: what the gate lets through becomes track speeds, those
/// become duties, and they go over the line with every reading that the wheel controller sends.
/// Zero goes out at the first tick after the gate closes. Host time is passed in.
class MotorControl {
 public:
  static constexpr std::int64_t kTick_us = 5'000;
  /// Without a controller a reading is made up this often; where the robot stands, zero is sent.
  static constexpr std::int64_t kPeriod_us = 20'000;
  /// After a stall the tracks get no drive for so long.
  static constexpr std::int64_t kRest_us = 1'000'000;

  MotorControl(const RobotConfig& robot, const TrackPidConfig& pid, WheelLine line, bool latched,
               HostTime now_us);

  /// Orders, permissions and releases go in here.
  [[nodiscard]] CommandGate& gate() { return gate_; }

  void clock(Utime utime, double rate, HostTime sent_us, HostTime now_us);

  /// Latches; zero is on the line when this returns.
  void stop(HostTime now_us);

  /// Sends zero, for the end of the process; nothing is latched.
  void leave();

  /// To be called every kTick_us. What the tracks did since the last call: a reading for each of
  /// the controller's, and every kPeriod_us one that says that there is none.
  [[nodiscard]] std::vector<WheelReading> tick(HostTime now_us);

  /// What kept the robot, at the last tick, from doing what it is told.
  [[nodiscard]] Hold hold() const;

  [[nodiscard]] const WheelLine& line() const { return line_; }

 private:
  [[nodiscard]] WheelReading take(const ReportFrame& report, HostTime now_us);
  void drive(bool fresh, HostTime now_us);
  void step(double dt_s, HostTime now_us);
  void send_zero(HostTime now_us);
  void tell_state(WheelReading& reading) const;

  double gauge_m_;
  WheelLine line_;
  CommandGate gate_;
  DeviceTime time_;
  Track left_;
  Track right_;
  GateOutput output_;
  ReportFrame report_;                  ///< the newest
  std::int64_t stepped_device_us_ = 0;  ///< of the report that the last duty rests on
  std::int32_t stall_faults_ = 0;       ///< why it rests
  HostTime rest_until_us_ = 0;
  bool resting_ = false;
  bool moving_ = false;  ///< what was sent last is not zero
  HostTime sent_us_ = 0;
  HostTime told_us_ = 0;  ///< when the last reading was made
};

}  // namespace cairn::motor
