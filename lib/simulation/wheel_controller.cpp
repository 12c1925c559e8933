// SPDX-License-Identifier: Apache-2.0
#include "simulation/wheel_controller.hpp"

namespace cairn::simulation {

void WheelController::receive(std::span<const std::uint8_t> bytes, std::int64_t host_us) {
  for (const std::uint8_t byte : bytes) {
    switch (parser_.take(byte)) {
      case motor::FrameParser::Kind::kDrive:
        obey(parser_.drive(), host_us);
        break;
      case motor::FrameParser::Kind::kStop:
        duty_ = {};
        break;
      default:
        break;
    }
  }
}

void WheelController::obey(const motor::DriveFrame& command, std::int64_t host_us) {
  if (commanded_ && static_cast<std::int32_t>(command.number - last_number_) <= 0) {
    ++refused_;
    return;
  }
  commanded_ = true;
  last_number_ = command.number;
  obeyed_us_ = host_us;
  duty_ = {command.left, command.right};
}

bool WheelController::starved(std::int64_t host_us) const {
  return !commanded_ || host_us - obeyed_us_ >= kWatchdog_us;
}

WheelController::Duty WheelController::duty(std::int64_t host_us) const {
  return starved(host_us) ? Duty{} : duty_;
}

motor::WireFrame WheelController::report(std::int64_t left_ticks, std::int64_t right_ticks,
                                         std::int64_t device_us, std::int64_t host_us) const {
  motor::ReportFrame report;
  report.session = session_;
  report.device_us = device_us;
  report.left_ticks = left_ticks;
  report.right_ticks = right_ticks;
  const Duty in_effect = duty(host_us);
  report.left_duty = in_effect.left;
  report.right_duty = in_effect.right;
  report.last_number = last_number_;
  if (starved(host_us)) report.faults |= motor::kControllerStarved;
  if (low_battery_) report.faults |= motor::kControllerLowBattery;
  report.firmware = kFirmware;
  return motor::to_wire(report);
}

}  // namespace cairn::simulation
