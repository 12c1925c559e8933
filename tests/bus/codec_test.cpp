// SPDX-License-Identifier: Apache-2.0
#include "bus/codec.hpp"

#include <gtest/gtest.h>

#include <cairn/clock_t.hpp>
#include <cairn/particles_t.hpp>

namespace cairn::bus {
namespace {

std::vector<std::uint8_t> one_tick() {
  cairn::clock_t tick{};
  tick.header.utime = 5;
  tick.rate = 1;
  return encode(tick).value();
}

TEST(Codec, WhatWasEncodedIsDecoded) {
  const auto tick = decode<cairn::clock_t>(one_tick());
  ASSERT_TRUE(tick);
  EXPECT_EQ(tick->header.utime, 5);
  EXPECT_EQ(tick->rate, 1.0);
}

TEST(Codec, BytesLeftOverAreRefused) {
  auto bytes = one_tick();
  bytes.push_back(0);
  EXPECT_EQ(decode<cairn::clock_t>(bytes).error().message,
            "1 bytes too many for a message of type clock_t");
}

TEST(Codec, AnotherTypeATruncatedAndAnEmptyMessageAreRefused) {
  auto bytes = one_tick();
  EXPECT_FALSE(decode<particles_t>(bytes));
  bytes.pop_back();
  EXPECT_FALSE(decode<cairn::clock_t>(bytes));
  EXPECT_FALSE(decode<cairn::clock_t>({}));
}

TEST(Codec, AHeaderThatNobodyWritesIsRefused) {
  cairn::clock_t tick{};
  tick.header.utime = -1;
  EXPECT_FALSE(decode<cairn::clock_t>(encode(tick).value()));
}

TEST(Codec, ACountThatIsNotItsVectorsSizeIsNotEncoded) {
  particles_t particles{};
  particles.count = 1000;
  EXPECT_FALSE(encode(particles));
}

}  // namespace
}  // namespace cairn::bus
