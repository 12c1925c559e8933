// SPDX-License-Identifier: Apache-2.0
#include "mapping/voxel_map.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <map>
#include <set>
#include <tuple>

#include "mapping/made_maps.hpp"

namespace cairn::mapping {
namespace {

VoxelClass expected_class(const EvidenceConfig& config, int occ, int emp) {
  const double all = occ + emp + config.prior;
  if (occ / all > config.occupied_share && occ >= config.occupied_support) {
    return VoxelClass::kOccupied;
  }
  if (emp / all > config.free_share && emp >= config.free_support) return VoxelClass::kFree;
  return VoxelClass::kUnknown;
}

TEST(EvidenceRule, FollowsItsFormulaForEveryPairOfCounters) {
  for (const double share : {0.25, 0.5, 0.75}) {
    EvidenceConfig config;
    config.prior = 3;
    config.occupied_share = share;
    config.occupied_support = 7;
    const EvidenceRule rule{config};
    for (int occ = 0; occ < 256; ++occ) {
      for (int emp = 0; emp < 256; ++emp) {
        ASSERT_EQ(rule.classify(static_cast<std::uint8_t>(occ), static_cast<std::uint8_t>(emp)),
                  expected_class(config, occ, emp))
            << occ << " occupied, " << emp << " empty, share " << share;
      }
    }
  }
}

TEST(VoxelMap, IsUnknownWhereNothingWasSeen) {
  const VoxelMap map{0.01};
  EXPECT_EQ(map.state(VoxelIndex{1, 2, 3}).voxel_class, VoxelClass::kUnknown);
  EXPECT_EQ(map.state(Eigen::Vector3d{1e9, 0, 0}).voxel_class, VoxelClass::kUnknown);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(map.state(Eigen::Vector3d{0, nan, 0}).voxel_class, VoxelClass::kUnknown);
}

TEST(VoxelMap, PointsFallIntoTheVoxelAroundThem) {
  const VoxelMap map{0.05};
  EXPECT_EQ(map.voxel_at({0.01, -0.01, 0.049}), (VoxelIndex{0, -1, 0}));
  EXPECT_EQ(map.voxel_at({-0.051, 0.051, -10.001}), (VoxelIndex{-2, 1, -201}));
  EXPECT_EQ(map.voxel_at(map.centre_of({-77, 8, 1000})), (VoxelIndex{-77, 8, 1000}));
}

TEST(VoxelMap, EvidenceClassesAndCountsFollowASimpleModel) {
  using Model = std::map<VoxelIndex, std::pair<int, int>>;
  std::mt19937 random{3};
  VoxelMap map{0.05};
  Model model;
  std::set<BrickIndex> touched;
  for (int i = 0; i < 400; ++i) {
    const BrickIndex brick = testing::random_brick(random, 1);
    const VoxelMask hits = testing::random_mask(random, 0.1);
    const bool all_free = i % 3 != 0;
    const VoxelMask misses = all_free ? VoxelMask::all() : testing::random_mask(random, 0.5);
    std::map<VoxelIndex, VoxelClass> before;
    for (int v = 0; v < kBrickVoxels; ++v) {
      const VoxelIndex voxel = voxel_in(brick, v);
      before[voxel] = map.state(voxel).voxel_class;
      auto& [occ, emp] = model[voxel];
      if (!all_free && hits.test(v)) {
        occ = std::min(255, occ + 9);
      } else if (misses.test(v)) {
        emp = std::min(255, emp + 3);
      }
    }
    const bool changed =
        all_free ? map.add_free(brick, 3) : map.add_evidence(brick, hits, misses, 9, 3);
    const bool expected = std::any_of(before.begin(), before.end(), [&](const auto& entry) {
      return map.state(entry.first).voxel_class != entry.second;
    });
    EXPECT_EQ(changed, expected);
    touched.insert(brick);
  }
  std::size_t known = 0;
  std::size_t occupied = 0;
  for (const auto& [voxel, evidence] : model) {
    const VoxelState state = map.state(voxel);
    ASSERT_EQ(state.occupied_evidence, evidence.first);
    ASSERT_EQ(state.empty_evidence, evidence.second);
    ASSERT_EQ(state.voxel_class, expected_class({}, evidence.first, evidence.second));
    known += state.voxel_class != VoxelClass::kUnknown ? 1 : 0;
    occupied += state.voxel_class == VoxelClass::kOccupied ? 1 : 0;
  }
  EXPECT_EQ(map.known_voxels(), known);
  EXPECT_EQ(map.occupied_voxels(), occupied);
  EXPECT_EQ(map.brick_count(), touched.size());
  EXPECT_GE(map.bytes(), touched.size() * 2 * kBrickVoxels);
}

TEST(VoxelMap, SetEvidenceReplacesAllThatAddEvidenceMade) {
  VoxelMap map = testing::random_map(4, 60, 2);
  const VoxelMap other = testing::random_map(5, 200, 2);
  other.grid().for_each([&](BrickIndex index, const EvidenceBrick& brick) {
    map.set_evidence(index, brick.occupied_evidence.of, brick.empty_evidence().of);
  });
  other.grid().for_each([&](BrickIndex index, const EvidenceBrick& brick) {
    const EvidenceBrick* copy = map.grid().find(index);
    ASSERT_NE(copy, nullptr);
    EXPECT_EQ(copy->known, brick.known);
    EXPECT_EQ(copy->occupied, brick.occupied);
    EXPECT_EQ(copy->has_hits, brick.has_hits);
  });
  std::size_t known = 0;
  map.grid().for_each([&](BrickIndex, const EvidenceBrick& brick) {
    known += static_cast<std::size_t>(brick.known.count());
  });
  EXPECT_EQ(map.known_voxels(), known);
}

TEST(VoxelMap, DirtyBricksAreThoseTouchedSinceLastCleared) {
  VoxelMap map{0.05};
  VoxelMask one;
  one.set(100);
  map.add_evidence({20, 0, 0}, one, {}, 1, 1);
  map.add_evidence({-3, 0, 0}, one, {}, 1, 1);
  map.add_evidence({20, 0, 0}, one, {}, 1, 1);
  EXPECT_EQ(map.dirty_bricks(), (std::vector<BrickIndex>{{-3, 0, 0}, {20, 0, 0}}));
  map.clear_dirty();
  EXPECT_TRUE(map.dirty_bricks().empty());
  map.add_evidence({20, 0, 0}, {}, one, 1, 1);
  EXPECT_EQ(map.dirty_bricks(), (std::vector<BrickIndex>{{20, 0, 0}}));
}

}  // namespace
}  // namespace cairn::mapping
