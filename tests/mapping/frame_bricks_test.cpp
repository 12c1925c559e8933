// SPDX-License-Identifier: Apache-2.0
#include "mapping/frame_bricks.hpp"

#include <gtest/gtest.h>

namespace cairn::mapping {
namespace {

TEST(MissLayers, EveryBitOfEveryAxisLandsOnItsVoxel) {
  for (int index = 0; index < kBrickVoxels; ++index) {
    const int x = index & 7;
    const int y = index >> 3 & 7;
    const int z = index >> 6;
    const auto one = [](int bit) { return std::uint64_t{1} << bit; };
    VoxelMask expected;
    expected.set(index);
    MissLayers along_x;
    along_x.words[0][static_cast<std::size_t>(x)] = one(y + 8 * z);
    EXPECT_EQ(along_x.mask(), expected);
    MissLayers along_y;
    along_y.words[1][static_cast<std::size_t>(y)] = one(x + 8 * z);
    EXPECT_EQ(along_y.mask(), expected);
    MissLayers along_z;
    along_z.words[2][static_cast<std::size_t>(z)] = one(x + 8 * y);
    EXPECT_EQ(along_z.mask(), expected);
  }
}

TEST(FrameBricks, NeighboursAreTheBricksAcrossTheFaces) {
  FrameBricks frame;
  const std::uint32_t start = frame.find_or_add({-1, 0, 5});
  const BrickIndex expected[6] = {{-2, 0, 5}, {0, 0, 5},  {-1, -1, 5},
                                  {-1, 1, 5}, {-1, 0, 4}, {-1, 0, 6}};
  for (std::size_t face = 0; face < 6; ++face) {
    const std::uint32_t other = frame.across(start, face);
    EXPECT_EQ(frame[other].index, expected[face]);
    EXPECT_EQ(frame.find_or_add(expected[face]), other);
    EXPECT_EQ(frame.across(other, face ^ 1), start);
  }
}

TEST(FrameBricks, KeepsItsBricksApartWhileItGrowsAndForgetsThemWhenCleared) {
  FrameBricks frame;
  std::uint32_t brick = frame.find_or_add({0, 0, 0});
  for (int i = 0; i < 5000; ++i) brick = frame.across(brick, 1);
  EXPECT_EQ(frame[brick].index, (BrickIndex{5000, 0, 0}));
  EXPECT_EQ(frame.find_or_add({1234, 0, 0}), 1234u);
  frame.clear();
  EXPECT_TRUE(frame.all().empty());
  EXPECT_EQ(frame.find_or_add({1234, 0, 0}), 0u);
  EXPECT_FALSE(frame[0].misses.mask().any());
}

}  // namespace
}  // namespace cairn::mapping
