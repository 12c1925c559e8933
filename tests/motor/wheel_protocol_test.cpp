// SPDX-License-Identifier: Apache-2.0
#include "motor/wheel_protocol.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

namespace cairn::motor {
namespace {

using Bytes = std::vector<std::uint8_t>;
using Kind = FrameParser::Kind;

Bytes bytes_of(const WireFrame& frame) { return {frame.bytes().begin(), frame.bytes().end()}; }

std::vector<Kind> take(FrameParser& parser, const Bytes& bytes) {
  std::vector<Kind> kinds;
  for (const std::uint8_t byte : bytes) {
    const Kind kind = parser.take(byte);
    if (kind != Kind::kNone) kinds.push_back(kind);
  }
  return kinds;
}

// Made by another program, from the page: zlib's CRC-32, and stuffing of its own.
const Bytes kDriveBytes{0x00, 0x05, 0x01, 0x01, 0x02, 0x01, 0x01, 0x01, 0x08,
                        0x40, 0x01, 0x80, 0x63, 0x24, 0x58, 0x7B, 0x00};
const Bytes kStopBytes{0x00, 0x07, 0x01, 0x02, 0x92, 0x42, 0xCC, 0xB6, 0x00};
const Bytes kReportBytes{0x00, 0x0A, 0x01, 0x81, 0xEF, 0xBE, 0xAD, 0xDE, 0x40, 0x42, 0x0F, 0x01,
                         0x01, 0x01, 0x01, 0x03, 0x88, 0x13, 0x01, 0x01, 0x01, 0x01, 0x01, 0x0B,
                         0xFD, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0x7F, 0x04, 0xE0,
                         0x02, 0x01, 0x01, 0x02, 0x09, 0x06, 0x01, 0x21, 0xF1, 0xF9, 0xEE, 0x00};
const Bytes kOtherVersionBytes{0x00, 0x04, 0x02, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01,
                               0x01, 0x01, 0x05, 0x96, 0xAC, 0xAE, 0x3C, 0x00};
const Bytes kUnknownBytes{0x00, 0x0A, 0x01, 0x55, 0x01, 0x02, 0x03, 0x32, 0x78, 0x6C, 0xAD, 0x00};

const DriveFrame kDrive{258, 0.5, -1};
const ReportFrame kReport{0xDEADBEEF, 1'000'000, 5000, -3, 1, -0.25, 258, 9, 0x0100};

void expect_same(const ReportFrame& got, const ReportFrame& sent) {
  EXPECT_EQ(got.session, sent.session);
  EXPECT_EQ(got.device_us, sent.device_us);
  EXPECT_EQ(got.left_ticks, sent.left_ticks);
  EXPECT_EQ(got.right_ticks, sent.right_ticks);
  EXPECT_NEAR(got.left_duty, sent.left_duty, 0.5 / 32767);
  EXPECT_NEAR(got.right_duty, sent.right_duty, 0.5 / 32767);
  EXPECT_EQ(got.last_number, sent.last_number);
  EXPECT_EQ(got.faults, sent.faults);
  EXPECT_EQ(got.firmware, sent.firmware);
}

TEST(WheelProtocol, FramesAreTheBytesOfThePage) {
  EXPECT_EQ(bytes_of(to_wire(kDrive)), kDriveBytes);
  EXPECT_EQ(bytes_of(to_wire(StopFrame{})), kStopBytes);
  EXPECT_EQ(bytes_of(to_wire(kReport)), kReportBytes);
}

TEST(WheelProtocol, TheBytesOfThePageAreFrames) {
  FrameParser parser;
  ASSERT_EQ(take(parser, kDriveBytes), std::vector{Kind::kDrive});
  EXPECT_EQ(parser.drive().number, 258u);
  EXPECT_NEAR(parser.drive().left, 0.5, 0.5 / 32767);
  EXPECT_EQ(parser.drive().right, -1);
  ASSERT_EQ(take(parser, kStopBytes), std::vector{Kind::kStop});
  ASSERT_EQ(take(parser, kReportBytes), std::vector{Kind::kReport});
  expect_same(parser.report(), kReport);
  EXPECT_EQ(parser.counts().good, 3);
}

TEST(WheelProtocol, AnotherVersionAndAnUnknownKindAreToldApartFromDamage) {
  FrameParser parser;
  EXPECT_TRUE(take(parser, kOtherVersionBytes).empty());
  EXPECT_EQ(parser.other_version(), 2);
  EXPECT_TRUE(take(parser, kUnknownBytes).empty());
  EXPECT_EQ(parser.counts().other_version, 1);
  EXPECT_EQ(parser.counts().unknown, 1);
  EXPECT_EQ(parser.counts().damaged, 0);
  EXPECT_EQ(parser.counts().good, 0);
}

TEST(WheelProtocol, DutiesAreBroughtWithinTheirLimitsAndWhatIsNoNumberIsNoDrive) {
  FrameParser parser;
  const double inf = std::numeric_limits<double>::infinity();
  const double nan = std::nan("");
  for (const auto& [given, sent] : {std::pair{2.0, 1.0}, {-1e300, -1.0}, {inf, 1.0}, {nan, 0.0}}) {
    take(parser, bytes_of(to_wire(DriveFrame{1, given, -given})));
    EXPECT_EQ(parser.drive().left, sent);
    EXPECT_EQ(parser.drive().right, -sent);
  }
}

TEST(WheelProtocol, AnyReportComesThroughInAnyPortions) {
  std::mt19937_64 random(1);
  FrameParser parser;
  for (int i = 0; i < 20'000; ++i) {
    const auto any = [&] { return random() >> (random() % 64); };
    const ReportFrame sent{static_cast<std::uint32_t>(any()),
                           static_cast<std::int64_t>(any()),
                           static_cast<std::int64_t>(any()),
                           -static_cast<std::int64_t>(any() >> 1),
                           2e-9 * static_cast<double>(any() % 500'000'000),
                           -2e-9 * static_cast<double>(any() % 500'000'000),
                           static_cast<std::uint32_t>(any()),
                           static_cast<std::uint8_t>(any()),
                           static_cast<std::uint16_t>(any())};
    ASSERT_EQ(take(parser, bytes_of(to_wire(sent))), std::vector{Kind::kReport});
    expect_same(parser.report(), sent);
  }
  EXPECT_EQ(parser.counts().damaged, 0);
}

bool holds(const Bytes& line, const Bytes& frame) {
  return std::search(line.begin(), line.end(), frame.begin(), frame.end()) != line.end();
}

TEST(WheelProtocol, HazardM12_NoDamagedFrameIsTaken) {
  std::mt19937 random(20240229);
  const auto below = [&](std::size_t end) {
    return std::uniform_int_distribution<std::size_t>(0, end - 1)(random);
  };
  for (const Bytes& whole : {kDriveBytes, kStopBytes, kReportBytes}) {
    for (int mutation = 0; mutation < 20'000; ++mutation) {
      Bytes damaged = whole;
      for (std::size_t edits = 1 + below(3); edits > 0; --edits) {
        const auto at = damaged.begin() + static_cast<std::ptrdiff_t>(below(damaged.size()));
        switch (below(4)) {
          case 0:
            *at = static_cast<std::uint8_t>(below(256));
            break;
          case 1:
            *at ^= static_cast<std::uint8_t>(1 << below(8));
            break;
          case 2:
            damaged.insert(at, static_cast<std::uint8_t>(below(256)));
            break;
          default:
            if (damaged.size() > 1) damaged.erase(at);
        }
      }
      damaged.insert(damaged.begin(), 0);
      damaged.push_back(0);
      if (holds(damaged, whole)) continue;
      FrameParser parser;
      ASSERT_TRUE(take(parser, damaged).empty());
      ASSERT_EQ(take(parser, whole).size(), 1u) << "the next whole frame must be taken";
    }
  }
}

TEST(WheelProtocol, HazardM12_AHalfFrameCostsNoMoreThanItself) {
  for (std::size_t size = 0; size + 1 < kReportBytes.size(); ++size) {
    FrameParser parser;
    Bytes line(kReportBytes.begin(), kReportBytes.begin() + static_cast<std::ptrdiff_t>(size));
    line.insert(line.end(), kDriveBytes.begin(), kDriveBytes.end());
    EXPECT_EQ(take(parser, line), std::vector{Kind::kDrive}) << size;
    Bytes tail(kReportBytes.begin() + static_cast<std::ptrdiff_t>(1 + size), kReportBytes.end());
    tail.insert(tail.end(), kStopBytes.begin(), kStopBytes.end());
    FrameParser late;
    const auto kinds = take(late, tail);
    ASSERT_FALSE(kinds.empty());
    EXPECT_EQ(kinds.back(), Kind::kStop);
  }
}

TEST(WheelProtocol, HazardM12_JunkIsCountedAndEndsWithTheNextFrame) {
  std::mt19937 random(7);
  FrameParser parser;
  std::int64_t taken = 0;
  for (int i = 0; i < 3'000'000; ++i) {
    if (parser.take(static_cast<std::uint8_t>(random())) != Kind::kNone) ++taken;
  }
  EXPECT_EQ(taken, 0);
  EXPECT_GT(parser.counts().damaged, 1000);
  EXPECT_EQ(take(parser, kDriveBytes), std::vector{Kind::kDrive});
  for (int i = 0; i < 100'000; ++i) EXPECT_EQ(parser.take(0x55), Kind::kNone);
  EXPECT_EQ(take(parser, kDriveBytes), std::vector{Kind::kDrive});
}

}  // namespace
}  // namespace cairn::motor
