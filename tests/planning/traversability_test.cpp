// SPDX-License-Identifier: Apache-2.0
#include "planning/traversability.hpp"

#include <gtest/gtest.h>

#include <numbers>
#include <random>

#include "made_ground.hpp"

namespace cairn::planning {
namespace {

using cairn::testing::MadeMap;
using mapping::VoxelClass;

constexpr double kWide_m = 1.5;

double level(double, double) { return 0; }

GroundMap judged(const VoxelColumns& columns, std::span<const BlockedSpot> blocked = {}) {
  const std::vector<KnownFloor> start{{{-1, -1}, 0.3, 0}};
  return judge_ground(columns, start, blocked, {}, {});
}

GroundMap judged(MadeMap& made) {
  mapping::MapReplica replica;
  const auto bricks = made.send(replica);
  VoxelColumns columns;
  columns.update(replica, bricks);
  return judged(columns);
}

ColumnClass at(const GroundMap& ground, double x_m, double y_m) {
  return ground.at(cell_at({x_m, y_m}));
}

class Resolution : public ::testing::TestWithParam<double> {};

TEST_P(Resolution, LevelFloorIsFreeAndWhatWasNotSeenIsUnknown) {
  MadeMap made(GetParam());
  made.floor(-kWide_m, kWide_m, level);
  const GroundMap ground = judged(made);
  for (double y = -1.4; y < 1.4; y += 0.05) {
    for (double x = -1.4; x < 1.4; x += 0.05) {
      ASSERT_EQ(at(ground, x, y), ColumnClass::kFree) << x << ", " << y;
    }
  }
  EXPECT_EQ(at(ground, 1.7, 0), ColumnClass::kUnknown);
  EXPECT_EQ(at(ground, 9, 9), ColumnClass::kUnknown);
}

TEST_P(Resolution, AThinLegIsInTheWay) {
  MadeMap made(GetParam());
  made.floor(-kWide_m, kWide_m, level);
  made.fill({0.5, 0.5, 0}, {0.53, 0.53, 0.7});
  made.set({0.515, 0.515, 0.25}, VoxelClass::kOccupied);  // coarse voxels may miss it above
  for (double z = 0.1; z < 0.7; z += 0.02) made.set({0.515, 0.515, z}, VoxelClass::kOccupied);
  const GroundMap ground = judged(made);
  EXPECT_EQ(at(ground, 0.515, 0.515), ColumnClass::kOccupied);
  EXPECT_EQ(at(ground, 0.7, 0.5), ColumnClass::kFree);
}

TEST_P(Resolution, ATableIsDrivenUnderAndALowShelfIsNot) {
  MadeMap made(GetParam());
  made.floor(-kWide_m, kWide_m, level);
  made.fill({0.2, 0.2, 0.70}, {0.8, 0.8, 0.75});
  made.fill({0.2, -0.8, 0.30}, {0.8, -0.2, 0.40});
  const GroundMap ground = judged(made);
  EXPECT_EQ(at(ground, 0.5, 0.5), ColumnClass::kFree);
  EXPECT_NEAR(ground.ceiling_m[ground.box.index(cell_at({0.5, 0.5}))], 0.70, 0.051);
  EXPECT_EQ(at(ground, 0.5, -0.5), ColumnClass::kOccupied);
}

INSTANTIATE_TEST_SUITE_P(Traversability, Resolution, ::testing::Values(0.01, 0.02, 0.04, 0.05));

TEST(Traversability, AVoxelWithinALayerOfTheFloorIsFloorAndALoneOneAboveIsNoise) {
  MadeMap made(0.02);
  made.floor(-kWide_m, kWide_m, level);
  made.set({0.3, 0.3, 0.03}, VoxelClass::kOccupied);
  made.set({0.6, 0.6, 0.25}, VoxelClass::kOccupied);
  const GroundMap ground = judged(made);
  EXPECT_EQ(at(ground, 0.3, 0.3), ColumnClass::kFree);
  EXPECT_EQ(at(ground, 0.6, 0.6), ColumnClass::kFree);
}

TEST(Traversability, AStepIsAWallFromBelowAndADropFromAbove) {
  for (const double step_m : {0.05, 0.15, -0.05, -0.15}) {
    MadeMap made(0.02);
    const auto height_m = [&](double x, double) { return x > 0.5 ? step_m : 0.0; };
    made.floor(-kWide_m, kWide_m, height_m);
    if (step_m < 0) {
      made.fill({0.5, -kWide_m, step_m + 0.02}, {kWide_m, kWide_m, 0.3}, VoxelClass::kFree);
    }
    const GroundMap ground = judged(made);
    EXPECT_EQ(at(ground, 0.45, 0), ColumnClass::kFree) << step_m;
    EXPECT_EQ(at(ground, 0.525, 0), ColumnClass::kOccupied) << step_m;
  }
}

TEST(Traversability, ARampOfEightDegreesIsFloorAndOneOfTwentyFiveIsNot) {
  for (const double slope_deg : {5.0, 8.0, 25.0}) {
    MadeMap made(0.02);
    const double slope = std::tan(slope_deg * std::numbers::pi / 180);
    made.floor(-kWide_m, kWide_m, [&](double x, double) { return std::max(0.0, slope * x); });
    const GroundMap ground = judged(made);
    if (slope_deg > 20) {
      EXPECT_NE(at(ground, 0.4, 0), ColumnClass::kFree);
    } else {
      EXPECT_EQ(at(ground, 1.2, 0), ColumnClass::kFree) << slope_deg;
      EXPECT_NEAR(ground.floor_m[ground.box.index(cell_at({1.2, 0}))], 1.2 * slope, 0.02);
    }
  }
}

TEST(Traversability, AGapIsFloorWhereRaysPassedOverItAndAWideOneIsNot) {
  MadeMap made(0.02);
  made.floor(-kWide_m, kWide_m, level);
  made.fill({0.50, -kWide_m, -0.1}, {0.60, kWide_m, 0.1}, VoxelClass::kUnknown);
  made.fill({0.50, 0.1, 0.04}, {0.60, kWide_m, 0.1}, VoxelClass::kFree);
  made.fill({-0.4, 0.3, -0.1}, {0.1, 0.8, 0.1}, VoxelClass::kUnknown);
  made.fill({-0.4, 0.3, 0.04}, {0.1, 0.8, 0.1}, VoxelClass::kFree);
  const GroundMap ground = judged(made);
  EXPECT_EQ(at(ground, 0.53, 0.5), ColumnClass::kFree);
  EXPECT_EQ(at(ground, 0.53, -0.5), ColumnClass::kUnknown) << "nothing passed over it";
  EXPECT_EQ(at(ground, -0.15, 0.55), ColumnClass::kUnknown);
}

TEST(Traversability, FloorBeyondAWallIsNotReached) {
  MadeMap made(0.02);
  made.floor(-kWide_m, kWide_m, level);
  made.fill({0.5, -2, 0}, {0.6, 2, 0.5});
  const GroundMap ground = judged(made);
  EXPECT_EQ(at(ground, 1, 0), ColumnClass::kUnknown);
  EXPECT_EQ(ground.reached[ground.box.index(cell_at({1, 0}))], 0);
}

TEST(Traversability, ClearanceIsNeverMoreThanTheTruth) {
  MadeMap made(0.02);
  made.floor(-kWide_m, kWide_m, level);
  made.fill({0.5, -0.2, 0}, {0.6, 0.2, 0.5});
  const GroundMap ground = judged(made);
  for (double x = -1.2; x < 0.4; x += 0.05) {
    const Eigen::Vector2d middle = centre_m(cell_at({x, 0}));
    EXPECT_LE(ground.clearance_m(cell_at({x, 0})), 0.5 - middle.x() + 1e-6);
    EXPECT_GE(ground.clearance_m(cell_at({x, 0})), 0.5 - middle.x() - 0.05);
  }
}

TEST(Traversability, ABlockedSpotIsOccupied) {
  MadeMap made(0.02);
  made.floor(-kWide_m, kWide_m, level);
  mapping::MapReplica replica;
  VoxelColumns columns;
  columns.update(replica, made.send(replica));
  EXPECT_EQ(at(judged(columns), 0.5, 0.5), ColumnClass::kFree);
  const std::vector<BlockedSpot> blocked{{{0.5, 0.5}, 0.12}};
  EXPECT_EQ(at(judged(columns, blocked), 0.5, 0.5), ColumnClass::kOccupied);
}

TEST(VoxelColumns, ReadingOnlyWhatChangedIsReadingAll) {
  constexpr unsigned kSeed = 5;
  std::mt19937 random(kSeed);
  std::uniform_real_distribution<double> place(-1, 1);
  std::uniform_real_distribution<double> height(-0.6, 1.2);
  for (const double resolution_m : {0.01, 0.015, 0.02, 0.03, 0.05}) {
    MadeMap made(resolution_m);
    mapping::MapReplica replica;
    VoxelColumns columns;
    for (int round = 0; round < 20; ++round) {
      for (int i = 0; i < 60; ++i) {
        const auto what = static_cast<VoxelClass>(random() % 3);
        made.set({place(random), place(random), height(random)}, what);
      }
      columns.update(replica, made.send(replica));
    }
    VoxelColumns fresh;
    std::vector<mapping::BrickIndex> all;
    replica.grid().for_each([&](mapping::BrickIndex brick, const auto&) { all.push_back(brick); });
    fresh.update(replica, all);
    for (std::size_t i = 0; i < columns.box().size(); ++i) {
      const Cell cell = columns.box().cell(i);
      const auto& incremental = columns.column(i);
      const auto expected = fresh.box().contains(cell) ? fresh.column(fresh.box().index(cell))
                                                       : VoxelColumns::Column{};
      ASSERT_EQ(incremental.occupied, expected.occupied) << resolution_m;
      ASSERT_EQ(incremental.free, expected.free) << resolution_m;
    }
  }
}

TEST(VoxelColumns, AFarAwayBrickTakesNoMemory) {
  MadeMap made(0.02);
  made.set({0, 0, 0}, VoxelClass::kOccupied);
  made.set({5000, 5000, 0}, VoxelClass::kOccupied);
  mapping::MapReplica replica;
  VoxelColumns columns;
  columns.update(replica, made.send(replica));
  EXPECT_LE(columns.box().size(), 5000U);
}

}  // namespace
}  // namespace cairn::planning
