// SPDX-License-Identifier: Apache-2.0
#include "mapping/brick_grid.hpp"

#include <gtest/gtest.h>

#include <map>
#include <random>
#include <tuple>

#include "mapping/made_maps.hpp"

namespace cairn::mapping {
namespace {

TEST(GridIndex, VoxelsBricksAndTilesAgreeOnBothSidesOfTheOrigin) {
  for (const std::int32_t x :
       {-kVoxelLimit, -129, -128, -9, -8, -1, 0, 7, 8, 127, 128, kVoxelLimit - 1}) {
    const VoxelIndex voxel{x, -x - 1, x / 2};
    const BrickIndex brick = brick_of(voxel);
    EXPECT_EQ(voxel_in(brick, index_in_brick(voxel)), voxel);
    EXPECT_EQ(brick_in(tile_of(brick), index_in_tile(brick)), brick);
    EXPECT_TRUE(within(voxel, kVoxelLimit));
    EXPECT_TRUE(within(brick, kBrickLimit));
    EXPECT_TRUE(within(tile_of(brick), kTileLimit));
  }
  EXPECT_EQ(brick_of({-1, 0, 8}), (BrickIndex{-1, 0, 1}));
  EXPECT_EQ(tile_of(BrickIndex{-1, 15, 16}), (TileIndex{-1, 0, 1}));
  EXPECT_FALSE(within(VoxelIndex{kVoxelLimit, 0, 0}, kVoxelLimit));
  EXPECT_FALSE(within(VoxelIndex{0, 0, -kVoxelLimit - 1}, kVoxelLimit));
}

TEST(GridIndex, PackedNumbersSortAsTheIndicesDo) {
  std::mt19937 random{1};
  for (int i = 0; i < 1000; ++i) {
    const BrickIndex a = testing::random_brick(random, kBrickLimit - 1);
    const BrickIndex b = testing::random_brick(random, 2);
    EXPECT_EQ(a < b, packed(a) < packed(b));
    EXPECT_EQ(b == BrickIndex{}, packed(b) == packed(BrickIndex{}));
  }
}

TEST(BrickGrid, HoldsWhatAMapHoldsAndGivesItSorted) {
  std::mt19937 random{2};
  BrickGrid<int> grid;
  std::map<std::tuple<TileIndex, int>, int> truth;
  for (int i = 1; i <= 20000; ++i) {
    const BrickIndex index = testing::random_brick(random, i % 10 == 0 ? kBrickLimit - 1 : 40);
    grid.find_or_add(index) = i;
    truth[{tile_of(index), index_in_tile(index)}] = i;
  }
  ASSERT_EQ(grid.brick_count(), truth.size());
  auto expected = truth.begin();
  BrickGrid<int>::Cursor cursor{grid};
  grid.for_each([&](BrickIndex index, int value) {
    ASSERT_NE(expected, truth.end());
    EXPECT_EQ(expected->first, (std::tuple{tile_of(index), index_in_tile(index)}));
    EXPECT_EQ(expected->second, value);
    ASSERT_NE(cursor.find(index), nullptr);
    EXPECT_EQ(*cursor.find(index), value);
    ++expected;
  });
  EXPECT_EQ(expected, truth.end());
  EXPECT_EQ(grid.find(BrickIndex{41, 0, 0}), nullptr);
  EXPECT_EQ(cursor.find(BrickIndex{41, 0, 0}), nullptr);
  EXPECT_GE(grid.bytes(), truth.size() * sizeof(int));
}

}  // namespace
}  // namespace cairn::mapping
