// SPDX-License-Identifier: Apache-2.0
#include "motor/serial_link.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <random>
#include <string>

#include "motor/motor_control.hpp"
#include "simulation/pseudo_terminal.hpp"
#include "temporary_folder.hpp"
#include "wheel_rig.hpp"

namespace cairn::motor {
namespace {

namespace fs = std::filesystem;
using simulation::PseudoTerminal;
using Bytes = std::vector<std::uint8_t>;

constexpr std::int64_t kMs = 1000;

std::ptrdiff_t open_files() {
  return std::distance(fs::directory_iterator("/proc/self/fd"), fs::directory_iterator{});
}

/// libserialport as it is, on a pseudo-terminal of the kernel's.
class SerialLinkTest : public ::testing::Test {
 protected:
  std::string error_of(const fs::path& device) {
    const auto opened = SerialLink::open(device, 115'200);
    return opened ? "" : opened.error().message;
  }

  testing::TemporaryFolder folder_;
  fs::path device_ = folder_.path() / "wheels";
};

TEST_F(SerialLinkTest, CarriesAllBytesBothWays) {
  auto terminal = PseudoTerminal::open(device_).value();
  auto link = SerialLink::open(device_, 115'200).value();
  Bytes all;
  for (int byte = 0; byte < 256; ++byte) all.push_back(static_cast<std::uint8_t>(byte));
  ASSERT_TRUE(link->write(all));
  EXPECT_EQ(terminal->read().value(), all);
  ASSERT_TRUE(terminal->write(all));
  EXPECT_EQ(link->read().value(), all);
  EXPECT_TRUE(link->read().value().empty());
}

TEST_F(SerialLinkTest, WhatCameBeforeItWasOpenedIsGone) {
  auto terminal = PseudoTerminal::open(device_).value();
  const Bytes old{1, 2, 3};
  ASSERT_TRUE(terminal->write(old));
  auto link = SerialLink::open(device_, 115'200).value();
  EXPECT_TRUE(link->read().value().empty());
}

TEST_F(SerialLinkTest, SaysWhatIsWrongWithADeviceAndWhatToDo) {
  EXPECT_NE(error_of("").find("set `device`"), std::string::npos);
  EXPECT_NE(error_of(device_).find(device_.string() + ": no such device"), std::string::npos);
  std::ofstream(folder_.path() / "file") << "text";
  EXPECT_NE(error_of(folder_.path() / "file").find("is no serial device"), std::string::npos);
  EXPECT_NE(error_of(folder_.path()).find("is no serial device"), std::string::npos);
  EXPECT_NE(error_of("/dev/null").find("/dev/null: "), std::string::npos);
  const auto terminal = PseudoTerminal::open(device_).value();
  const auto first = SerialLink::open(device_, 115'200).value();
  EXPECT_NE(error_of(device_).find("is in use by another program"), std::string::npos);
}

TEST_F(SerialLinkTest, ALineWhoseOtherEndIsGoneSaysSo) {
  auto terminal = PseudoTerminal::open(device_).value();
  auto link = SerialLink::open(device_, 115'200).value();
  terminal.reset();
  EXPECT_FALSE(link->read());
}

TEST_F(SerialLinkTest, AFailedOpeningLeavesNoFileOpen) {
  (void)error_of(device_);
  const auto before = open_files();
  for (int i = 0; i < 100; ++i) {
    (void)error_of(device_);
    (void)error_of("/dev/null");
    (void)error_of(folder_.path());
  }
  EXPECT_EQ(open_files(), before);
}

/// All of motor but its bus on a real line, and the reference controller on the other side.
class DrivenLine {
 public:
  explicit DrivenLine(fs::path device) : device_{std::move(device)} {}

  void plug_in() { rig_.emplace(PseudoTerminal::open(device_).value(), ++session_, now_us_); }
  void pull_out() { rig_.reset(); }

  void pass(std::int64_t duration_us) {
    for (const HostTime until_us = now_us_ + duration_us; now_us_ < until_us;) {
      now_us_ += kMs;
      if (now_us_ % (50 * kMs) == 0) {
        control_.clock(now_us_, 1, now_us_, now_us_);
        (void)control_.gate().permit({{now_us_, 1, ++sequence_}, 0.5, now_us_}, now_us_);
        if (driver)
          (void)control_.gate().drive({{now_us_, 2, ++sequence_}, Driver::kPlanner, 0, 0.3, 0.1},
                                      now_us_);
      }
      if (rig_) rig_->run(now_us_);
      if (now_us_ % MotorControl::kTick_us != 0) continue;
      for (const WheelReading& reading : control_.tick(now_us_)) faults = reading.faults;
    }
  }

  [[nodiscard]] testing::WheelRig& rig() { return *rig_; }
  [[nodiscard]] const MotorControl& control() const { return control_; }
  [[nodiscard]] HostTime now_us() const { return now_us_; }

  bool driver = true;
  std::int32_t faults = 0;

 private:
  fs::path device_;
  HostTime now_us_ = 1'000'000;
  std::uint32_t session_ = 0;
  std::int32_t sequence_ = 0;
  std::optional<testing::WheelRig> rig_;
  MotorControl control_{{},
                        {},
                        WheelLine(device_.string(),
                                  [this]() -> Result<std::unique_ptr<ByteLink>> {
                                    return SerialLink::open(device_, 115'200);
                                  }),
                        false,
                        1'000'000};
};

TEST_F(SerialLinkTest, HazardM13_FiftyTimesOutAndInWhileDriving) {
  DrivenLine line(device_);
  line.plug_in();
  line.pass(700 * kMs);
  const auto before = open_files();
  std::int64_t slowest_back_us = 0;
  for (int round = 0; round < 50; ++round) {
    ASSERT_TRUE(line.rig().driven()) << round;
    line.pull_out();
    line.driver = false;
    const HostTime out_us = line.now_us();
    while ((line.faults & kFaultNoController) == 0) {
      line.pass(kMs);
      ASSERT_LE(line.now_us() - out_us, 200 * kMs);
    }
    line.pass((round % 7) * 300 * kMs);
    line.plug_in();
    const HostTime in_us = line.now_us();
    while (line.faults != 0) {
      line.pass(kMs);
      ASSERT_LE(line.now_us() - in_us, 2000 * kMs);
    }
    slowest_back_us = std::max(slowest_back_us, line.now_us() - in_us);
    line.pass(500 * kMs);
    ASSERT_FALSE(line.rig().driven()) << "nobody has told it to since";
    line.driver = true;
    line.pass(300 * kMs);
  }
  EXPECT_EQ(open_files(), before);
  EXPECT_EQ(line.control().line().counts().lost, 50);
  std::printf("back after at most %.0f ms\n", 1e-3 * static_cast<double>(slowest_back_us));
}

TEST_F(SerialLinkTest, HazardM12_JunkAmongTheReportsCostsOnlyWhatItHits) {
  DrivenLine line(device_);
  auto terminal = PseudoTerminal::open(device_).value();
  std::mt19937 random(11);
  // A line that puts junk before and into what it carries.
  class Noisy : public ByteLink {
   public:
    Noisy(std::unique_ptr<PseudoTerminal> line, std::mt19937& random)
        : line_{std::move(line)}, random_{random} {}
    [[nodiscard]] Result<Bytes> read() override { return line_->read(); }
    [[nodiscard]] Result<void> write(std::span<const std::uint8_t> bytes) override {
      Bytes noisy(random_() % 20);
      for (std::uint8_t& byte : noisy) byte = static_cast<std::uint8_t>(random_());
      noisy.insert(noisy.end(), bytes.begin(), bytes.end());
      if (random_() % 5 == 0) noisy[random_() % noisy.size()] ^= 0x40;
      if (random_() % 10 == 0) noisy.resize(noisy.size() / 2);
      return line_->write(noisy);
    }

   private:
    std::unique_ptr<PseudoTerminal> line_;
    std::mt19937& random_;
  };
  testing::WheelRig rig(std::make_unique<Noisy>(std::move(terminal), random), 1, line.now_us());
  double top_mps = 0;
  int connected = 0;
  for (int ms = 0; ms < 20'000; ++ms) {
    line.pass(kMs);
    rig.run(line.now_us());
    top_mps = std::max({top_mps, std::abs(rig.left.speed_mps), std::abs(rig.right.speed_mps)});
    connected += line.control().line().connected() ? 1 : 0;
  }
  EXPECT_GT(connected, 19'000);
  EXPECT_LT(top_mps, 0.36) << "the right track is told 0.313";
  EXPECT_NEAR(rig.right.speed_mps, 0.313, 0.02);
  EXPECT_GT(line.control().line().counts().frames.damaged, 100);
}

TEST_F(SerialLinkTest, HazardM19_ADeviceThatSpeaksNonsenseMovesNothingAndIsSaid) {
  DrivenLine line(device_);
  auto far = PseudoTerminal::open(device_).value();
  std::mt19937 random(5);
  FrameParser heard;
  for (int ms = 0; ms < 5'000; ++ms) {
    Bytes junk(random() % 50);
    for (std::uint8_t& byte : junk) byte = static_cast<std::uint8_t>(random());
    (void)far->write(junk);
    line.pass(kMs);
    const auto bytes = far->read().value();
    for (const std::uint8_t byte : bytes) ASSERT_NE(heard.take(byte), FrameParser::Kind::kDrive);
  }
  EXPECT_EQ(line.faults, kFaultNoController);
  EXPECT_NE(line.control().line().trouble().find(device_.string() + ": what comes is no frame"),
            std::string::npos)
      << line.control().line().trouble();
  EXPECT_GT(line.control().line().counts().frames.damaged, 100);
  EXPECT_GE(line.control().line().counts().lost, 2);
}

}  // namespace
}  // namespace cairn::motor
