// SPDX-License-Identifier: Apache-2.0
#include "odometry/checkpoint.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <random>

#include "core/checksum.hpp"

namespace cairn::odometry {
namespace {

Checkpoint some_checkpoint() {
  Checkpoint checkpoint;
  checkpoint.utime = 1234567890123;
  checkpoint.epoch = 7;
  checkpoint.T_odom_body.linear() = rotation_from_rpy(0.1, -0.2, 2.9);
  checkpoint.T_odom_body.translation() = Eigen::Vector3d(1.5, -2.25, 0.125);
  checkpoint.twist << 0.3, 0, -0.01, 0, 0.02, 0.5;
  return checkpoint;
}

/// Puts a right checksum behind bytes that were changed on purpose.
void seal(std::vector<std::uint8_t>& bytes) {
  const std::uint64_t sum = fnv1a_64(std::span(bytes).first(bytes.size() - 8));
  for (std::size_t i = 0; i < 8; ++i) {
    bytes[bytes.size() - 8 + i] = static_cast<std::uint8_t>(sum >> (8 * i));
  }
}

void put_number(std::vector<std::uint8_t>& bytes, std::size_t at, double number) {
  const auto bits = std::bit_cast<std::uint64_t>(number);
  for (std::size_t i = 0; i < 8; ++i) bytes[at + i] = static_cast<std::uint8_t>(bits >> (8 * i));
}

TEST(Checkpoint, ComesBackAsItWas) {
  const Checkpoint original = some_checkpoint();
  const auto bytes = to_bytes(original);
  EXPECT_EQ(bytes.size(), 177U);
  const auto back = checkpoint_from_bytes(bytes);
  ASSERT_TRUE(back) << back.error().message;
  EXPECT_EQ(back->utime, original.utime);
  EXPECT_EQ(back->epoch, original.epoch);
  EXPECT_EQ(back->twist, original.twist);
  EXPECT_TRUE(back->T_odom_body.isApprox(original.T_odom_body, 1e-14));
}

TEST(Checkpoint, RefusesDamage) {
  const auto whole = to_bytes(some_checkpoint());
  constexpr unsigned kSeed = 99;
  SCOPED_TRACE(kSeed);
  std::mt19937 random(kSeed);
  for (int i = 0; i < 2000; ++i) {
    auto bytes = whole;
    if (random() % 4 == 0) {
      bytes.resize(random() % bytes.size());
    } else {
      bytes[random() % bytes.size()] ^= static_cast<std::uint8_t>(1 + random() % 255);
    }
    const auto read = checkpoint_from_bytes(bytes);
    ASSERT_FALSE(read);
    ASSERT_FALSE(read.error().message.empty());
  }
  EXPECT_FALSE(checkpoint_from_bytes({}));
}

TEST(Checkpoint, RefusesNumbersThatAreNoPose) {
  for (std::size_t at = 16; at < 16 + 13 * 8; at += 8) {
    for (const double poison : {std::nan(""), HUGE_VAL}) {
      auto bytes = to_bytes(some_checkpoint());
      put_number(bytes, at, poison);
      seal(bytes);
      EXPECT_FALSE(checkpoint_from_bytes(bytes)) << at;
    }
  }
  auto bytes = to_bytes(some_checkpoint());
  put_number(bytes, 40, 0.5);
  seal(bytes);
  EXPECT_FALSE(checkpoint_from_bytes(bytes)) << "a quaternion that is not of unit length";
}

}  // namespace
}  // namespace cairn::odometry
