// SPDX-License-Identifier: Apache-2.0
#include "mapping/raycast.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "mapping/made_maps.hpp"

namespace cairn::mapping {
namespace {

/// Where a ray enters the box of a voxel (slabs, Kay and Kajiya 1986); infinity where it misses it.
double entry_m(const VoxelIndex& voxel, double side_m, const Eigen::Vector3d& origin,
               const Eigen::Vector3d& direction) {
  const Eigen::Array3d low = side_m * Eigen::Array3d(voxel.x, voxel.y, voxel.z);
  const Eigen::Array3d a = (low - origin.array()) / direction.array();
  const Eigen::Array3d b = (low + side_m - origin.array()) / direction.array();
  const double enter = std::max(0.0, a.min(b).maxCoeff());
  const double leave = a.max(b).minCoeff();
  return enter <= leave ? enter : std::numeric_limits<double>::infinity();
}

TEST(Raycast, FindsTheNearestOfAllOccupiedVoxels) {
  const unsigned seed = 21;
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937 random{seed};
  std::normal_distribution<double> normal;
  VoxelMap map{0.05};
  std::vector<VoxelIndex> occupied;
  for (int i = 0; i < 120; ++i) {
    const BrickIndex brick = testing::random_brick(random, 4);
    map.add_evidence(brick, testing::random_mask(random, 0.05), {}, 20, 1);
  }
  map.grid().for_each([&](BrickIndex index, const EvidenceBrick& brick) {
    for_each_voxel(brick.occupied, [&](int i) { occupied.push_back(voxel_in(index, i)); });
  });
  int hits = 0;
  for (int i = 0; i < 3000; ++i) {
    const Eigen::Vector3d origin{normal(random), normal(random), normal(random)};
    const Eigen::Vector3d direction =
        Eigen::Vector3d{normal(random), normal(random), normal(random)}.normalized();
    double nearest_m = std::numeric_limits<double>::infinity();
    for (const VoxelIndex& voxel : occupied) {
      nearest_m = std::min(nearest_m, entry_m(voxel, 0.05, origin, direction));
    }
    const auto hit = raycast(map, origin, 3.7 * direction, 5);
    ASSERT_EQ(hit.has_value(), nearest_m <= 5) << "ray " << i;
    if (!hit) continue;
    ASSERT_NEAR(hit->distance_m, nearest_m, 1e-9) << "ray " << i;
    ASSERT_NEAR(entry_m(hit->voxel, 0.05, origin, direction), nearest_m, 1e-9);
    EXPECT_FALSE(raycast(map, origin, direction, nearest_m - 1e-6));
    ++hits;
  }
  EXPECT_GT(hits, 500);
}

TEST(Raycast, RunsAlongTheAxesFromCornersAndStartsInsideAVoxel) {
  VoxelMap map{0.1};
  VoxelMask one;
  one.set(0);
  map.add_evidence({-2, 0, 0}, one, {}, 20, 1);  // voxel (-16, 0, 0)
  const auto hit = raycast(map, {0, 0, 0}, {-1, 0, 0}, 10);
  ASSERT_TRUE(hit);
  EXPECT_NEAR(hit->distance_m, 1.5, 1e-12);
  EXPECT_EQ(hit->voxel, (VoxelIndex{-16, 0, 0}));
  EXPECT_FALSE(raycast(map, {0, 0, 0}, {1, 0, 0}, 10));
  EXPECT_FALSE(raycast(map, {0, 0, 0}, {0, 1, 0}, 10));
  const auto inside = raycast(map, {-1.55, 0.05, 0.05}, {1, 2, 3}, 10);
  ASSERT_TRUE(inside);
  EXPECT_EQ(inside->distance_m, 0);
}

TEST(Raycast, AReplicaAnswersAsItsMapDoes) {
  const VoxelMap map = testing::random_map(22, 100, 4);
  MapReplica replica;
  EXPECT_FALSE(raycast(replica, {0, 0, 0}, {1, 0, 0}, 5));
  std::vector<BrickIndex> bricks;
  map.grid().for_each([&](BrickIndex index, const EvidenceBrick&) { bricks.push_back(index); });
  ASSERT_TRUE(replica.apply(make_delta(map, 1, 1, bricks)));
  std::mt19937 random{23};
  std::normal_distribution<double> normal;
  for (int i = 0; i < 500; ++i) {
    const Eigen::Vector3d direction{normal(random), normal(random), normal(random)};
    const auto from_map = raycast(map, {0.01, 0.02, 0.03}, direction, 5);
    const auto from_replica = raycast(replica, {0.01, 0.02, 0.03}, direction, 5);
    ASSERT_EQ(from_map.has_value(), from_replica.has_value());
    EXPECT_EQ(from_map ? from_map->distance_m : -1, from_replica ? from_replica->distance_m : -1);
  }
}

TEST(Raycast, GivesNothingForWhatIsNoRay) {
  const VoxelMap map = testing::random_map(24, 100, 2);
  const double nan = std::nan("");
  const double inf = std::numeric_limits<double>::infinity();
  EXPECT_FALSE(raycast(map, {nan, 0, 0}, {1, 0, 0}, 5));
  EXPECT_FALSE(raycast(map, {0, 0, 0}, {nan, 0, 0}, 5));
  EXPECT_FALSE(raycast(map, {0, 0, 0}, {0, 0, 0}, 5));
  EXPECT_FALSE(raycast(map, {0, 0, 0}, {1, 0, 0}, nan));
  EXPECT_FALSE(raycast(map, {0, 0, 0}, {1, 0, 0}, -1));
  EXPECT_FALSE(raycast(map, {0, 0, 0}, {1, 0, 0}, inf));
  EXPECT_FALSE(raycast(map, {1e300, 0, 0}, {1, 0, 0}, 5));
}

}  // namespace
}  // namespace cairn::mapping
