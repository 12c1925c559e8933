// SPDX-License-Identifier: Apache-2.0
#include "procs/cli/teleop.hpp"

#include <gtest/gtest.h>

#include <random>
#include <string>
#include <vector>

namespace cairn::cli {
namespace {

constexpr std::int64_t kMs = 1000;

class TeleopTest : public ::testing::Test {
 protected:
  void type(const std::string& keys) {
    teleop_.type({reinterpret_cast<const std::uint8_t*>(keys.data()), keys.size()}, now_us_);
  }
  void expect(double forward, double turn) const {
    EXPECT_EQ(teleop_.forward_mps(now_us_), forward);
    EXPECT_EQ(teleop_.turn_radps(now_us_), turn);
  }
  HostTime now_us_ = 5'000'000;
  Teleop teleop_{0.2, 0.6};
};

TEST_F(TeleopTest, DrivesOnlyWhileAKeyIsRepeated) {
  expect(0, 0);
  for (int i = 0; i < 100; ++i) {
    type("w");
    expect(0.2, 0);
    now_us_ += 30 * kMs;
  }
  now_us_ += Teleop::kHold_us - 31 * kMs;
  expect(0.2, 0);
  now_us_ += kMs;
  expect(0, 0);
}

TEST_F(TeleopTest, KnowsLettersAndArrowsInBothFormsAndInPortions) {
  const std::vector<std::tuple<std::string, double, double>> keys{
      {"w", 0.2, 0},      {"S", -0.2, 0},      {"a", 0, 0.6},      {"D", 0, -0.6},
      {"\x1b[A", 0.2, 0}, {"\x1bOB", -0.2, 0}, {"\x1b[D", 0, 0.6}, {"\x1bOC", 0, -0.6}};
  for (const auto& [key, forward, turn] : keys) {
    now_us_ += 1000 * kMs;
    for (const char byte : key) type(std::string(1, byte));
    expect(forward, turn);
  }
}

TEST_F(TeleopTest, AnyOtherKeyLetsGo) {
  type("w");
  type("x");
  expect(0, 0);
}

TEST_F(TeleopTest, TheSpaceBarStopsOnceAndQQuits) {
  type("w ");
  expect(0, 0);
  EXPECT_TRUE(teleop_.take_stop());
  EXPECT_FALSE(teleop_.take_stop());
  EXPECT_FALSE(teleop_.quit());
  type("wq");
  expect(0, 0);
  EXPECT_TRUE(teleop_.quit());
}

TEST_F(TeleopTest, WhateverIsTypedTheSpeedsAreThoseGivenOrZeroAndEndAfterTheHold) {
  std::mt19937 random(9);
  for (int i = 0; i < 100'000; ++i) {
    type(std::string(1, static_cast<char>(random())));
    for (const double way : {teleop_.forward_mps(now_us_) / 0.2, teleop_.turn_radps(now_us_) / 0.6})
      ASSERT_TRUE(way == 0 || way == 1 || way == -1);
    now_us_ += static_cast<std::int64_t>(random() % 20'000);
  }
  now_us_ += Teleop::kHold_us;
  expect(0, 0);
}

}  // namespace
}  // namespace cairn::cli
