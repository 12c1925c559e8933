// SPDX-License-Identifier: Apache-2.0
#include "simulation/wheel_controller.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <optional>
#include <random>
#include <vector>

namespace cairn::simulation {
namespace {

constexpr std::int64_t kNow_us = 10'000'000;

void command(WheelController& controller, std::uint32_t number, double left, double right,
             std::int64_t host_us) {
  const auto wire = motor::to_wire(motor::DriveFrame{number, left, right});
  controller.receive(wire.bytes(), host_us);
}

motor::ReportFrame read(const motor::WireFrame& wire) {
  motor::FrameParser parser;
  std::optional<motor::ReportFrame> report;
  for (const std::uint8_t byte : wire.bytes()) {
    if (parser.take(byte) == motor::FrameParser::Kind::kReport) report = parser.report();
  }
  EXPECT_TRUE(report.has_value());
  return report.value_or(motor::ReportFrame{});
}

TEST(WheelController, StandsUntilItIsTold) {
  const WheelController controller(7);
  EXPECT_EQ(controller.duty(kNow_us).left, 0);
  const auto report = read(controller.report(0, 0, 0, kNow_us));
  EXPECT_EQ(report.session, 7U);
  EXPECT_EQ(report.faults & motor::kControllerStarved, motor::kControllerStarved);
}

TEST(WheelController, ObeysTheNewestCommandForTwoHundredMilliseconds) {
  WheelController controller(1);
  command(controller, 1, 0.25, -0.5, kNow_us);
  const auto duty = controller.duty(kNow_us + WheelController::kWatchdog_us - 1);
  EXPECT_NEAR(duty.left, 0.25, 1e-4);
  EXPECT_NEAR(duty.right, -0.5, 1e-4);
  const auto late = controller.duty(kNow_us + WheelController::kWatchdog_us);
  EXPECT_EQ(late.left, 0);
  EXPECT_EQ(late.right, 0);
  command(controller, 2, 0.1, 0.1, kNow_us + 400'000);
  EXPECT_NEAR(controller.duty(kNow_us + 400'000).left, 0.1, 1e-4);
}

TEST(WheelController, ARepeatedOrOlderCommandIsRefusedAndKeepsNothingAlive) {
  WheelController controller(1);
  command(controller, 5, 0.25, 0.25, kNow_us);
  command(controller, 5, 0.9, 0.9, kNow_us + 150'000);
  command(controller, 4, 0.9, 0.9, kNow_us + 150'000);
  EXPECT_EQ(controller.refused(), 2);
  EXPECT_NEAR(controller.duty(kNow_us + 190'000).left, 0.25, 1e-4);
  EXPECT_EQ(controller.duty(kNow_us + 200'000).left, 0);
  EXPECT_EQ(read(controller.report(0, 0, 0, kNow_us)).last_number, 5U);
}

TEST(WheelController, NumbersMayWrap) {
  WheelController controller(1);
  command(controller, std::numeric_limits<std::uint32_t>::max(), 0.2, 0.2, kNow_us);
  command(controller, 0, 0.3, 0.3, kNow_us);
  EXPECT_NEAR(controller.duty(kNow_us).left, 0.3, 1e-4);
}

TEST(WheelController, StopIsAtOnce) {
  WheelController controller(1);
  command(controller, 1, 0.5, 0.5, kNow_us);
  controller.receive(motor::to_wire(motor::StopFrame{}).bytes(), kNow_us + 1);
  EXPECT_EQ(controller.duty(kNow_us + 1).left, 0);
  EXPECT_EQ(controller.duty(kNow_us + 1).right, 0);
}

TEST(WheelController, ReportsItsTicksItsTimeAndWhatIsInEffect) {
  WheelController controller(3);
  command(controller, 9, 0.5, -0.25, kNow_us);
  const auto report = read(controller.report(-123'456, 654'321, 77'000, kNow_us + 1000));
  EXPECT_EQ(report.left_ticks, -123'456);
  EXPECT_EQ(report.right_ticks, 654'321);
  EXPECT_EQ(report.device_us, 77'000);
  EXPECT_NEAR(report.left_duty, 0.5, 1e-4);
  EXPECT_NEAR(report.right_duty, -0.25, 1e-4);
  EXPECT_EQ(report.faults, 0);
  EXPECT_EQ(report.firmware, WheelController::kFirmware);
}

TEST(WheelController, DamagedBytesMoveNothingAndKeepNothingAlive) {
  std::mt19937 random(11);
  const auto good = motor::to_wire(motor::DriveFrame{1, 0.75, 0.75});
  for (int trial = 0; trial < 2000; ++trial) {
    WheelController controller(1);
    std::vector<std::uint8_t> bytes(good.bytes().begin(), good.bytes().end());
    const std::size_t at = 1 + random() % (bytes.size() - 2);
    bytes[at] = static_cast<std::uint8_t>(bytes[at] ^ (1 + random() % 255));
    controller.receive(bytes, kNow_us);
    const auto duty = controller.duty(kNow_us);
    EXPECT_EQ(duty.left, 0) << trial;
    EXPECT_EQ(duty.right, 0) << trial;
    // The next whole one is understood.
    controller.receive(good.bytes(), kNow_us);
    command(controller, 2, 0.5, 0.5, kNow_us);
    EXPECT_NEAR(controller.duty(kNow_us).left, 0.5, 1e-4) << trial;
  }
}

}  // namespace
}  // namespace cairn::simulation
