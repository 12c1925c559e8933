// SPDX-License-Identifier: Apache-2.0
#include "localization/distance_field.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <vector>

namespace cairn::localization {
namespace {

using mapping::BrickClasses;
using mapping::BrickIndex;
using mapping::MapDelta;
using mapping::MapReplica;
using mapping::VoxelClass;

/// A map that changes at random: a few voxels of a brick are occupied, some free, the others
/// unknown.
class ChangingMap {
 public:
  ChangingMap(double resolution_m, unsigned seed) : resolution_m_{resolution_m}, random_{seed} {}

  void change(int bricks, std::int32_t reach, double occupied_share) {
    std::uniform_int_distribution<std::int32_t> at{-reach, reach};
    std::discrete_distribution<int> what{1 - occupied_share, 0.3, occupied_share};
    MapDelta delta{1, ++utime_, resolution_m_, {}};
    for (int i = 0; i < bricks; ++i) {
      const std::int32_t x = at(random_);
      const std::int32_t y = at(random_);
      BrickClasses brick{{x, y, at(random_)}, 0, {}};
      for (int voxel = 0; voxel < mapping::kBrickVoxels; ++voxel) {
        brick.classes[static_cast<std::size_t>(voxel / 4)] |=
            static_cast<std::uint8_t>(what(random_) << (2 * (voxel % 4)));
      }
      delta.bricks.push_back(brick);
    }
    ASSERT_TRUE(replica.apply(delta));
  }

  MapReplica replica;

 private:
  double resolution_m_;
  std::mt19937 random_;
  Utime utime_ = 0;
};

struct Cell {
  bool known = false;
  bool occupied = false;
};

/// Every cell that the map says something about, voxel by voxel.
std::map<CellIndex, Cell> cells_of(const MapReplica& map, int voxels_per_cell) {
  std::map<CellIndex, Cell> cells;
  map.grid().for_each([&](BrickIndex brick, const mapping::ClassBrick&) {
    for (int i = 0; i < mapping::kBrickVoxels; ++i) {
      const mapping::VoxelIndex voxel = mapping::voxel_in(brick, i);
      const auto down = [&](std::int32_t v) {
        return static_cast<std::int32_t>(std::floor(static_cast<double>(v) / voxels_per_cell));
      };
      Cell& cell = cells[{down(voxel.x), down(voxel.y), down(voxel.z)}];
      const VoxelClass is = map.voxel_class(voxel);
      cell.known |= is != VoxelClass::kUnknown;
      cell.occupied |= is == VoxelClass::kOccupied;
    }
  });
  return cells;
}

std::uint8_t by_brute_force(const std::map<CellIndex, Cell>& cells, CellIndex at) {
  double least = DistanceField::kReach_cells;
  for (const auto& [cell, is] : cells) {
    if (!is.occupied) continue;
    const double dx = cell.x - at.x;
    const double dy = cell.y - at.y;
    const double dz = cell.z - at.z;
    least = std::min(least, std::sqrt(dx * dx + dy * dy + dz * dz));
  }
  const auto steps = static_cast<std::uint8_t>(std::lround(DistanceField::kStepsPerCell * least));
  const auto found = cells.find(at);
  const bool known = found != cells.end() && found->second.known;
  return static_cast<std::uint8_t>(steps | (known ? 0 : DistanceField::kUnknownBit));
}

void expect_like_brute_force(const DistanceField& field, const MapReplica& map, std::int32_t reach,
                             unsigned seed) {
  const auto cells = cells_of(map, field.voxels_per_cell());
  std::mt19937 random{seed};
  std::uniform_int_distribution<std::int32_t> at{-reach, reach};
  for (int i = 0; i < 400; ++i) {
    const std::int32_t x = at(random);
    const std::int32_t y = at(random);
    const CellIndex cell{x, y, at(random)};
    ASSERT_EQ(field.at(cell), by_brute_force(cells, cell))
        << cell.x << " " << cell.y << " " << cell.z;
  }
  std::size_t occupied = 0;
  for (const auto& [cell, is] : cells) {
    occupied += is.occupied ? 1 : 0;
    EXPECT_EQ(field.occupied(cell), is.occupied);
  }
  EXPECT_EQ(field.occupied_cells(), occupied);
}

void catch_up(DistanceField& field) {
  while (field.behind() > 0) (void)field.work({}, 1000);
}

TEST(DistanceField, IsAsBruteForceForVoxelsOfEverySize) {
  unsigned seed = 1;
  for (const double resolution_m : {0.005, 0.01, 0.02, 0.04, 0.05, 0.2}) {
    ChangingMap map(resolution_m, ++seed);
    map.change(12, 3, 0.002);
    DistanceField field;
    field.take(map.replica, map.replica.take_changes());
    catch_up(field);
    EXPECT_LE(field.cell_m(), std::max(0.045, resolution_m));
    expect_like_brute_force(field, map.replica, 40, seed);
  }
}

TEST(DistanceField, IncrementallyItIsAsBruteForceAndAsFromScratch) {
  for (const double resolution_m : {0.01, 0.02, 0.05}) {
    ChangingMap map(resolution_m, 7);
    DistanceField field;
    for (int round = 0; round < 12; ++round) {
      // Now and then all of a brick is emptied again.
      map.change(4, 3, round % 3 == 2 ? 0 : 0.003);
      field.take(map.replica, map.replica.take_changes());
      catch_up(field);
      expect_like_brute_force(field, map.replica, 45, static_cast<unsigned>(100 + round));
    }
    DistanceField fresh;
    std::vector<BrickIndex> all;
    map.replica.grid().for_each(
        [&](BrickIndex brick, const mapping::ClassBrick&) { all.push_back(brick); });
    fresh.take(map.replica, {true, all});
    catch_up(fresh);
    for (std::int32_t z = -45; z < 45; z += 2) {
      for (std::int32_t y = -45; y < 45; y += 2) {
        for (std::int32_t x = -45; x < 45; ++x) {
          ASSERT_EQ(field.at({x, y, z}), fresh.at({x, y, z}));
        }
      }
    }
  }
}

TEST(DistanceField, WhatWasNeverSeenIsUnknownAndFar) {
  const DistanceField field;
  EXPECT_EQ(field.at({0, 0, 0}), DistanceField::kFar | DistanceField::kUnknownBit);
  EXPECT_EQ(field.at(field.cell_at({1e30, -1e30, 0})),
            DistanceField::kFar | DistanceField::kUnknownBit);
}

TEST(DistanceField, DoesNoMoreThanItIsAllowedAndWhatIsWantedFirst) {
  ChangingMap map(0.02, 3);
  map.change(40, 10, 0.01);
  DistanceField field;
  field.take(map.replica, map.replica.take_changes());
  const std::size_t all = field.behind();
  ASSERT_GT(all, 200u);
  const std::vector<Eigen::Vector3d> wanted{{0.5, 0.3, -0.2}};
  EXPECT_EQ(field.work(wanted, 20), 20u);
  EXPECT_EQ(field.behind(), all - 20);
  const auto cells = cells_of(map.replica, field.voxels_per_cell());
  const CellIndex cell = field.cell_at(wanted[0]);
  EXPECT_EQ(field.at(cell), by_brute_force(cells, cell));
  std::size_t done = 20;
  while (field.behind() > 0) done += field.work({}, 50);
  EXPECT_EQ(done, all);
}

TEST(DistanceField, ANewMapLeavesNothingOfTheOldOne) {
  ChangingMap map(0.02, 3);
  map.change(10, 3, 0.05);
  DistanceField field;
  field.take(map.replica, map.replica.take_changes());
  catch_up(field);
  ASSERT_GT(field.occupied_cells(), 0u);
  MapDelta other{2, 1000, 0.05, {}};
  ASSERT_TRUE(map.replica.apply(other));
  field.take(map.replica, map.replica.take_changes());
  EXPECT_EQ(field.occupied_cells(), 0u);
  EXPECT_EQ(field.behind(), 0u);
  EXPECT_EQ(field.grid().brick_count(), 0u);
  EXPECT_EQ(field.cell_m(), 0.05);
}

}  // namespace
}  // namespace cairn::localization
