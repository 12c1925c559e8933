// SPDX-License-Identifier: Apache-2.0
#include "motor/wheel_line.hpp"

#include <gtest/gtest.h>

#include <deque>
#include <limits>
#include <string>
#include <vector>

#include "motor/memory_link.hpp"

namespace cairn::motor {
namespace {

constexpr std::int64_t kMs = 1000;
constexpr HostTime kStart_us = 50'000'000;

/// A line whose far end is played by the test; it can be missing, and be plugged in and out.
class WheelLineTest : public ::testing::Test {
 protected:
  void plug_in() {
    auto [far, near] = make_memory_links();
    far_ = std::move(far);
    waiting_ = std::move(near);
    there_ = true;
  }
  void pull_out() {
    far_.reset();
    waiting_.reset();
    there_ = false;
  }

  Result<std::unique_ptr<ByteLink>> open() {
    opened_us_.push_back(now_us_);
    if (!there_) return fail("/dev/wheels: no such device");
    if (waiting_ == nullptr) plug_in();
    return std::move(waiting_);
  }

  WheelLine::News pass(std::int64_t duration_us) {
    WheelLine::News all;
    for (const HostTime until_us = now_us_ + duration_us; now_us_ < until_us;) {
      now_us_ += 5 * kMs;
      auto news = line_.poll(now_us_);
      if (news.anew) all = {};
      all.anew = all.anew || news.anew;
      all.reports.insert(all.reports.end(), news.reports.begin(), news.reports.end());
    }
    return all;
  }

  void report(std::uint32_t session, std::int64_t device_us, std::uint32_t last_number = 0,
              std::int64_t ticks = 0) {
    ASSERT_TRUE(far_->write(
        to_wire(ReportFrame{session, device_us, ticks, ticks, 0, 0, last_number, 0, 1}).bytes()));
  }
  /// A controller that is well, for so long.
  void reports_for(std::int64_t duration_us) {
    for (const HostTime until_us = now_us_ + duration_us; now_us_ < until_us;) {
      report(1, now_us_);
      (void)pass(20 * kMs);
    }
  }
  std::vector<DriveFrame> driven() {
    std::vector<DriveFrame> frames;
    const auto bytes = far_->read().value();
    for (const std::uint8_t byte : bytes) {
      const auto kind = heard_.take(byte);
      if (kind == FrameParser::Kind::kDrive) frames.push_back(heard_.drive());
      if (kind == FrameParser::Kind::kStop) ++stops_;
    }
    return frames;
  }
  bool trouble_says(const std::string& words) const {
    return line_.trouble().find(words) != std::string::npos;
  }

  HostTime now_us_ = kStart_us;
  bool there_ = false;
  std::unique_ptr<ByteLink> far_;
  std::unique_ptr<ByteLink> waiting_;
  std::vector<HostTime> opened_us_;
  FrameParser heard_;
  int stops_ = 0;
  WheelLine line_{"/dev/wheels", [this] { return open(); }};
};

TEST_F(WheelLineTest, AMissingDeviceIsSaidAndTriedAgainAfterWaitsThatDouble) {
  (void)pass(6'000 * kMs);
  EXPECT_FALSE(line_.connected());
  EXPECT_TRUE(trouble_says("/dev/wheels: no such device"));
  std::vector<std::int64_t> waits_ms;
  for (std::size_t i = 1; i < opened_us_.size(); ++i)
    waits_ms.push_back((opened_us_[i] - opened_us_[i - 1]) / kMs);
  EXPECT_EQ(waits_ms, (std::vector<std::int64_t>{50, 100, 200, 400, 800, 1000, 1000, 1000, 1000}));
  EXPECT_EQ(line_.counts().not_opened, 10);
  EXPECT_EQ(line_.counts().opened, 0);
}

TEST_F(WheelLineTest, AControllerIsThereOnceItReportsAndNothingButAStopIsSentBefore) {
  plug_in();
  (void)pass(20 * kMs);
  line_.drive(0.5, 0.5);
  EXPECT_TRUE(driven().empty());
  EXPECT_EQ(stops_, 1);
  EXPECT_FALSE(line_.connected());
  report(1, 1000);
  EXPECT_FALSE(pass(5 * kMs).anew);
  EXPECT_FALSE(line_.connected()) << "one report may be an accident";
  report(1, 21'000);
  const auto news = pass(5 * kMs);
  EXPECT_TRUE(news.anew);
  EXPECT_EQ(news.reports.size(), 1u);
  EXPECT_TRUE(line_.connected());
  EXPECT_EQ(line_.trouble(), "");
  line_.drive(0.5, -0.5);
  ASSERT_EQ(driven().size(), 1u);
}

TEST_F(WheelLineTest, NumbersGoOnFromTheLastThatTheControllerObeyed) {
  plug_in();
  (void)pass(5 * kMs);
  // A former motor got as far as this; its number is about to wrap.
  report(1, 500, std::numeric_limits<std::uint32_t>::max() - 2);
  report(1, 1000, std::numeric_limits<std::uint32_t>::max() - 1);
  (void)pass(5 * kMs);
  for (int i = 0; i < 3; ++i) line_.drive(0, 0);
  auto frames = driven();
  ASSERT_EQ(frames.size(), 3u);
  EXPECT_EQ(frames[0].number, std::numeric_limits<std::uint32_t>::max());
  EXPECT_EQ(frames[1].number, 0u);
  EXPECT_EQ(frames[2].number, 1u);
  // What the former motor had sent was still underway.
  report(1, 2000, 40);
  (void)pass(5 * kMs);
  line_.drive(0, 0);
  EXPECT_EQ(driven().at(0).number, 41u);
  // A report that is behind what was sent takes nothing back.
  report(1, 3000, 35);
  (void)pass(5 * kMs);
  line_.drive(0, 0);
  EXPECT_EQ(driven().at(0).number, 42u);
}

TEST_F(WheelLineTest, ASilentControllerIsMissedAfter150MsAndTheLineIsOpenedAnew) {
  plug_in();
  reports_for(200 * kMs);
  ASSERT_TRUE(line_.connected());
  // The last report came 15 ms ago.
  (void)pass(WheelLine::kSilence_us - 15 * kMs);
  EXPECT_TRUE(line_.connected());
  (void)pass(5 * kMs);
  EXPECT_FALSE(line_.connected());
  EXPECT_TRUE(trouble_says("has fallen silent")) << line_.trouble();
  (void)pass(950 * kMs);
  EXPECT_EQ(line_.counts().lost, 1);
  EXPECT_EQ(line_.counts().opened, 2);
  EXPECT_TRUE(trouble_says("has fallen silent")) << line_.trouble();
  (void)pass(WheelLine::kSilence_us + 10 * kMs);
  EXPECT_TRUE(trouble_says("nothing comes from the wheel controller")) << line_.trouble();
}

TEST_F(WheelLineTest, ADeviceThatSpeaksNonsenseIsSaidToBeNoWheelController) {
  plug_in();
  const std::string nmea = "$GPGGA,123519,4807.038,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,*47\r\n";
  for (int i = 0; i < 100; ++i) {
    const bool written =
        far_->write({reinterpret_cast<const std::uint8_t*>(nmea.data()), nmea.size()}).has_value();
    EXPECT_TRUE(written || i > 0);
    (void)pass(20 * kMs);
    EXPECT_FALSE(line_.connected());
  }
  EXPECT_TRUE(trouble_says("what comes is no frame")) << line_.trouble();
  EXPECT_GE(line_.counts().lost, 1);
  EXPECT_GT(line_.counts().bytes, 1000);
}

TEST_F(WheelLineTest, AnotherVersionOfTheProtocolIsNamed) {
  plug_in();
  const std::vector<std::uint8_t> version_2{0x00, 0x04, 0x02, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01,
                                            0x01, 0x01, 0x05, 0x96, 0xAC, 0xAE, 0x3C, 0x00};
  for (int i = 0; i < 12; ++i) {
    ASSERT_TRUE(far_->write(version_2));
    (void)pass(20 * kMs);
  }
  EXPECT_FALSE(line_.connected());
  EXPECT_TRUE(trouble_says("speaks version 2 of the protocol, and motor version 1"))
      << line_.trouble();
  EXPECT_EQ(line_.counts().frames.other_version, 12);
}

TEST_F(WheelLineTest, ReportsThatCannotBeTrueAreCountedAndNotTaken) {
  plug_in();
  reports_for(100 * kMs);
  const std::int64_t far_away = std::numeric_limits<std::int64_t>::max();
  report(1, now_us_, 0, far_away);
  report(1, now_us_, 0, -far_away);
  report(1, -5, 0, 0);
  report(1, far_away, 0, 0);
  report(1, 1, 0, 0);  // its clock goes back
  EXPECT_TRUE(pass(5 * kMs).reports.empty());
  EXPECT_EQ(line_.counts().senseless, 5);
  for (int i = 0; i < 20; ++i) {
    report(1, 1, 0, 0);
    (void)pass(20 * kMs);
  }
  EXPECT_FALSE(line_.connected());
  EXPECT_TRUE(trouble_says("cannot be true")) << line_.trouble();
}

TEST_F(WheelLineTest, AControllerThatStartsAnewIsToldFromTheOneBefore) {
  plug_in();
  reports_for(100 * kMs);
  report(1, now_us_ + kMs, 700);
  report(2, 1000, 0);
  report(2, 21'000, 0);
  const auto news = pass(5 * kMs);
  EXPECT_TRUE(news.anew);
  ASSERT_EQ(news.reports.size(), 1u);
  EXPECT_EQ(news.reports[0].session, 2u);
  EXPECT_EQ(news.reports[0].device_us, 21'000);
  line_.drive(0, 0);
  EXPECT_EQ(driven().back().number, 1u);
}

TEST_F(WheelLineTest, HazardM13_APulledPlugIsNoticedAtOnceAndBackWithinTwoSeconds) {
  plug_in();
  for (int round = 0; round < 50; ++round) {
    reports_for(60 * kMs);
    ASSERT_TRUE(line_.connected());
    pull_out();
    (void)pass(5 * kMs);
    ASSERT_FALSE(line_.connected());
    ASSERT_NE(line_.trouble(), "");
    (void)pass((1 + round % 40) * 100 * kMs);
    plug_in();
    const HostTime from_us = now_us_;
    while (!line_.connected() && now_us_ - from_us < 3'000 * kMs) reports_for(20 * kMs);
    EXPECT_LE(now_us_ - from_us, 2'000 * kMs);
  }
  EXPECT_EQ(line_.counts().lost, 50);
}

TEST_F(WheelLineTest, ALineThatTakesNoMoreIsOpenedAnew) {
  plug_in();
  reports_for(100 * kMs);
  for (int i = 0; i < 5'000; ++i) line_.drive(0, 0);
  (void)pass(5 * kMs);
  EXPECT_FALSE(line_.connected());
  EXPECT_TRUE(trouble_says("full"));
  (void)pass(100 * kMs);
  EXPECT_EQ(line_.counts().opened, 2);
}

}  // namespace
}  // namespace cairn::motor
