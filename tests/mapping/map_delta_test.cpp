// SPDX-License-Identifier: Apache-2.0
#include "mapping/map_delta.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

#include "mapping/made_maps.hpp"
#include "mapping/map_replica.hpp"

namespace cairn::mapping {
namespace {

constexpr std::uint64_t kMapId = 77;

MapDelta one_brick_delta(std::uint64_t map_id, Utime utime, VoxelClass voxel_class) {
  MapDelta delta{map_id, utime, 0.05, {BrickClasses{}}};
  delta.bricks[0].classes[0] = static_cast<std::uint8_t>(voxel_class);
  return delta;
}

void expect_same_classes(const MapReplica& replica, const VoxelMap& map) {
  map.grid().for_each([&](BrickIndex index, const EvidenceBrick& brick) {
    const ClassBrick* copy = replica.grid().find(index);
    if (copy == nullptr) {
      EXPECT_FALSE(brick.known.any());
      return;
    }
    EXPECT_EQ(copy->known, brick.known);
    EXPECT_EQ(copy->occupied, brick.occupied);
  });
}

TEST(BrickClasses, SayForEveryVoxelWhatTheMapSays) {
  const VoxelMap map = testing::random_map(11, 40, 1);
  map.grid().for_each([&](BrickIndex index, const EvidenceBrick&) {
    const BrickClasses classes = classes_of(map, index);
    EXPECT_EQ(classes.brick, index);
    for (int i = 0; i < kBrickVoxels; ++i) {
      ASSERT_EQ(classes.at(i), map.state(voxel_in(index, i)).voxel_class);
    }
  });
  EXPECT_EQ(classes_of(map, {900, 0, 0}).classes, BrickClasses{}.classes);
}

TEST(MapReplica, EqualsTheMapHoweverDeltasAreRepeatedSplitAndShuffled) {
  const unsigned seed = 12;
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937 random{seed};
  VoxelMap map{0.05};
  std::vector<MapDelta> sent;
  for (Utime utime = 100; utime < 140; ++utime) {
    std::vector<BrickIndex> changed;
    for (int i = 0; i < 12; ++i) {
      const BrickIndex brick = testing::random_brick(random, 2);
      const VoxelMask hits = testing::random_mask(random, 0.2);
      if (map.add_evidence(brick, hits, testing::random_mask(random, 0.4), 20, 30)) {
        changed.push_back(brick);
      }
    }
    const std::span<const BrickIndex> all{changed};
    sent.push_back(make_delta(map, kMapId, utime, all.first(all.size() / 2)));
    sent.push_back(make_delta(map, kMapId, utime, all.subspan(all.size() / 2)));
  }
  std::vector<MapDelta> received = sent;
  received.insert(received.end(), sent.begin(), sent.end());
  std::shuffle(received.begin(), received.end(), random);
  for (const auto& order : {sent, received}) {
    MapReplica replica;
    for (const MapDelta& delta : order) ASSERT_TRUE(replica.apply(delta));
    expect_same_classes(replica, map);
    EXPECT_EQ(replica.utime(), 139);
    EXPECT_EQ(replica.map_id(), kMapId);
    for (const MapDelta& delta : order) ASSERT_TRUE(replica.apply(delta));
    expect_same_classes(replica, map);
  }
}

TEST(MapReplica, ANewerDeltaOfAnotherMapBeginsAnewAndAnOlderOneIsPassedOver) {
  MapReplica replica;
  ASSERT_TRUE(replica.apply(one_brick_delta(1, 10, VoxelClass::kOccupied)));
  EXPECT_EQ(replica.voxel_class({0, 0, 0}), VoxelClass::kOccupied);
  ASSERT_TRUE(replica.apply(MapDelta{2, 20, 0.05, {}}));
  EXPECT_EQ(replica.map_id(), 2u);
  EXPECT_EQ(replica.voxel_class({0, 0, 0}), VoxelClass::kUnknown);
  const auto late = replica.apply(one_brick_delta(1, 15, VoxelClass::kFree));
  ASSERT_TRUE(late);
  EXPECT_EQ(*late, 0u);
  EXPECT_EQ(replica.map_id(), 2u);
  EXPECT_EQ(replica.voxel_class({0, 0, 0}), VoxelClass::kUnknown);
}

TEST(MapReplica, RefusesADeltaThatCannotBeAndTakesNothingOfIt) {
  MapReplica replica;
  ASSERT_TRUE(replica.apply(one_brick_delta(1, 10, VoxelClass::kOccupied)));
  const auto refused = [&](const MapDelta& delta, const char* why) {
    const auto result = replica.apply(delta);
    ASSERT_FALSE(result);
    EXPECT_NE(result.error().message.find(why), std::string::npos) << result.error().message;
    EXPECT_EQ(replica.voxel_class({0, 0, 0}), VoxelClass::kOccupied);
    EXPECT_EQ(replica.utime(), 10);
  };
  MapDelta bad_class = one_brick_delta(1, 20, VoxelClass::kFree);
  bad_class.bricks.push_back({});
  bad_class.bricks[1].classes[127] = 0xc0;
  refused(bad_class, "class 3");
  MapDelta far_off = one_brick_delta(1, 20, VoxelClass::kFree);
  far_off.bricks[0].brick.y = kBrickLimit;
  refused(far_off, "outside");
  MapDelta level = one_brick_delta(1, 20, VoxelClass::kFree);
  level.bricks[0].level = 1;
  refused(level, "level 1");
  MapDelta resolution = one_brick_delta(1, 20, VoxelClass::kFree);
  resolution.resolution_m = 0;
  refused(resolution, "resolution");
}

}  // namespace
}  // namespace cairn::mapping
