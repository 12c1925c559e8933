// SPDX-License-Identifier: Apache-2.0
#include "motor/motor_control.hpp"

#include <algorithm>
#include <utility>

namespace cairn::motor {

MotorControl::MotorControl(const RobotConfig& robot, const TrackPidConfig& pid, WheelLine line,
                           bool latched, HostTime now_us)
    : gauge_m_{robot.track_gauge_m},
      line_{std::move(line)},
      gate_{{robot.max_speed_mps, robot.max_turn_radps, robot.track_gauge_m}, latched, now_us},
      left_{pid, robot.max_acceleration_mps2, robot.ticks_per_m},
      right_{pid, robot.max_acceleration_mps2, robot.ticks_per_m} {}

void MotorControl::clock(Utime utime, double rate, HostTime sent_us, HostTime now_us) {
  time_.tick(utime, rate, std::clamp(sent_us, now_us - kMicrosecondsPerSecond, now_us));
  gate_.clock(utime, sent_us, now_us);
}

void MotorControl::stop(HostTime now_us) {
  gate_.stop(now_us);
  leave();
  left_.stand();
  right_.stand();
  moving_ = false;
  sent_us_ = now_us;
}

void MotorControl::leave() {
  line_.stop();
  line_.drive(0, 0);
}

std::vector<WheelReading> MotorControl::tick(HostTime now_us) {
  const bool was_connected = line_.connected();
  const WheelLine::News news = line_.poll(now_us);
  if (news.anew) {
    time_.restart();
    left_.restart();
    right_.restart();
    stepped_device_us_ = news.reports.front().device_us;
  }
  if (news.anew || (was_connected && !line_.connected())) gate_.forget(now_us);
  std::vector<WheelReading> readings;
  for (const ReportFrame& report : news.reports) readings.push_back(take(report, now_us));
  drive(!news.reports.empty(), now_us);
  if (readings.empty() && !line_.connected() && now_us - told_us_ >= kPeriod_us) {
    readings.emplace_back();
    readings.back().utime = time_.data_now(now_us);
    readings.back().left_ticks = report_.left_ticks;
    readings.back().right_ticks = report_.right_ticks;
  }
  if (!readings.empty()) told_us_ = now_us;
  for (WheelReading& reading : readings) tell_state(reading);
  return readings;
}

WheelReading MotorControl::take(const ReportFrame& report, HostTime now_us) {
  report_ = report;
  left_.add(report.device_us, report.left_ticks, report.left_duty);
  right_.add(report.device_us, report.right_ticks, report.right_duty);
  WheelReading reading;
  reading.utime = time_.stamp(report.device_us, now_us);
  reading.left_ticks = report.left_ticks;
  reading.right_ticks = report.right_ticks;
  reading.left_measured_mps = left_.measured_mps();
  reading.right_measured_mps = right_.measured_mps();
  return reading;
}

void MotorControl::drive(bool fresh, HostTime now_us) {
  output_ = gate_.output(now_us, time_.data_now(now_us));
  resting_ = now_us < rest_until_us_;
  if (!line_.connected() || output_.stands() || resting_) return send_zero(now_us);
  if (!fresh) return;
  const double dt_s = to_seconds(report_.device_us - stepped_device_us_);
  stepped_device_us_ = report_.device_us;
  step(dt_s, now_us);
}

void MotorControl::step(double dt_s, HostTime now_us) {
  stall_faults_ =
      (left_.stalled() ? kFaultStalledLeft : 0) | (right_.stalled() ? kFaultStalledRight : 0);
  if (stall_faults_ != 0) {
    rest_until_us_ = now_us + kRest_us;
    resting_ = true;
    return send_zero(now_us);
  }
  const double half_turn_mps = output_.turn_radps * gauge_m_ / 2;
  const double left = left_.step(output_.forward_mps - half_turn_mps, dt_s);
  const double right = right_.step(output_.forward_mps + half_turn_mps, dt_s);
  line_.drive(left, right);
  moving_ = left != 0 || right != 0;
  sent_us_ = now_us;
}

// Sent at once where it moved, then as often as keeps the controller's watchdog at rest.
void MotorControl::send_zero(HostTime now_us) {
  left_.stand();
  right_.stand();
  stepped_device_us_ = report_.device_us;
  if (!line_.connected()) {
    if (moving_) line_.stop();
  } else if (moving_ || now_us - sent_us_ >= kPeriod_us) {
    line_.drive(0, 0);
    sent_us_ = now_us;
  }
  moving_ = false;
}

Hold MotorControl::hold() const {
  if (output_.hold == Hold::kLatched) return Hold::kLatched;
  if (!line_.connected()) return Hold::kNoController;
  return resting_ ? Hold::kStalled : output_.hold;
}

void MotorControl::tell_state(WheelReading& reading) const {
  reading.left_commanded_mps = left_.commanded_mps();
  reading.right_commanded_mps = right_.commanded_mps();
  if (!line_.connected()) reading.faults |= kFaultNoController;
  if (resting_) reading.faults |= stall_faults_;
  if ((report_.faults & kControllerLowBattery) != 0) reading.faults |= kFaultLowBattery;
  const bool held = !line_.connected() || resting_;
  reading.gate = output_.state == GateState::kDriving && held ? GateState::kIdle : output_.state;
}

}  // namespace cairn::motor
