// SPDX-License-Identifier: Apache-2.0
#include "mapping/integrator.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>

#include "mapping/made_images.hpp"
#include "mapping/projective_integrator.hpp"
#include "mapping/ray_integrator.hpp"

namespace cairn::mapping {
namespace {

using testing::image_of;
using testing::pose;
using testing::small_camera;
using testing::to_range;

/// What must hold however voxels are freed.
template <class SomeIntegrator>
class Integrators : public ::testing::Test {};

using Kinds = ::testing::Types<RayIntegrator, ProjectiveIntegrator>;
TYPED_TEST_SUITE(Integrators, Kinds);

TYPED_TEST(Integrators, AWallIsOccupiedFreeBeforeAndUnknownBehind) {
  // From x = 0.02 a wall 2 m ahead lies in the voxels [2.00, 2.05).
  constexpr double kRes_m = 0.05;
  VoxelMap map{kRes_m};
  TypeParam integrator{to_range(3)};
  const auto image = image_of(small_camera(320, 240), 2, [](int, int) { return 2.0; });
  const Isometry T_map_camera = pose({0.02, 0, 0}, 0, 0, 0);
  std::size_t changed = 0;
  for (int frame = 0; frame < 2; ++frame) {
    const auto result = integrator.integrate(image, T_map_camera, map);
    ASSERT_TRUE(result);
    EXPECT_EQ(result->rays, 160u * 120u);
    EXPECT_EQ(result->hits, result->rays);
    changed = result->changed.size();
    EXPECT_TRUE(std::is_sorted(result->changed.begin(), result->changed.end()));
  }
  EXPECT_EQ(changed, map.brick_count());
  int checked = 0;
  for (int y = -18; y < 18; ++y) {
    for (int z = -13; z < 13; ++z) {
      EXPECT_EQ(map.state(VoxelIndex{40, y, z}).voxel_class, VoxelClass::kOccupied)
          << y << " " << z;
      for (int x = 41; x < 60; ++x) {
        EXPECT_EQ(map.state(VoxelIndex{x, y, z}).voxel_class, VoxelClass::kUnknown);
      }
      for (int x = 1; x < 40; ++x) {
        const bool in_view = std::abs(y + 0.5) + 1 < 0.5 * x && std::abs(z + 0.5) + 1 < 0.375 * x;
        if (!in_view) continue;
        EXPECT_EQ(map.state(VoxelIndex{x, y, z}).voxel_class, VoxelClass::kFree)
            << x << " " << y << " " << z;
        ++checked;
      }
    }
  }
  EXPECT_GT(checked, 5000);
}

TYPED_TEST(Integrators, AHitWinsOverTheRaysThatPassThroughTheSameVoxel) {
  // Every other pixel sees a wall at 2 m, the rest look past it.
  VoxelMap map{0.2};
  TypeParam integrator{to_range(4)};
  const auto image = image_of(small_camera(64, 48), 1,
                              [](int row, int col) { return (row + col) % 2 == 0 ? 2.0 : 3.2; });
  ASSERT_TRUE(integrator.integrate(image, pose({0.1, 0.1, 0.1}, 0, 0, 0), map));
  const VoxelState wall = map.state(Eigen::Vector3d{2.1, 0.1, 0.1});
  EXPECT_EQ(wall.occupied_evidence, RayIntegratorConfig{}.hit_evidence);
  EXPECT_EQ(wall.empty_evidence, 0);
}

TYPED_TEST(Integrators, BeyondMaxRangeFreesTheWayThereAndHitsNothing) {
  VoxelMap map{0.1};
  TypeParam integrator{to_range(3)};
  const auto image = image_of(small_camera(160, 120), 1, [](int, int) { return 10.0; });
  for (int frame = 0; frame < 2; ++frame) {
    const auto result = integrator.integrate(image, pose({0.05, 0.05, 0.05}, 0, 0, 0), map);
    ASSERT_TRUE(result);
    EXPECT_EQ(result->hits, 0u);
  }
  EXPECT_EQ(map.occupied_voxels(), 0u);
  EXPECT_EQ(map.state(Eigen::Vector3d{2.85, 0.05, 0.05}).voxel_class, VoxelClass::kFree);
  EXPECT_EQ(map.state(Eigen::Vector3d{3.25, 0.05, 0.05}).voxel_class, VoxelClass::kUnknown);
}

TYPED_TEST(Integrators, PixelsWithoutAnAnswerTooNearOrOfLowConfidenceSayNothing) {
  VoxelMap map{0.1};
  RayIntegratorConfig config = to_range(3);
  config.min_range_m = 1;
  config.min_confidence = 2;
  TypeParam integrator{config};
  auto image = image_of(small_camera(64, 48), 1, [](int row, int) { return row < 24 ? 0.0 : 0.5; });
  image.disparity_16ths(40, 40) = 16 * 40;  // 2 m
  image.code(40, 40) = 1;
  const auto result = integrator.integrate(image, pose({0, 0, 0}, 0, 0, 0), map);
  ASSERT_TRUE(result);
  EXPECT_EQ(result->rays, 0u);
  EXPECT_EQ(result->voxels, 0u);
  EXPECT_TRUE(result->changed.empty());
  EXPECT_EQ(map.brick_count(), 0u);
}

TYPED_TEST(Integrators, DisparityAtInfinityFreesUpToMaxRange) {
  VoxelMap map{0.1};
  TypeParam integrator{to_range(3)};
  auto image = image_of(small_camera(64, 48), 1, [](int, int) { return 80.0; });
  image.camera.doffs_px = -2;  // disparity 1 less 2
  const auto result = integrator.integrate(image, pose({0.05, 0.05, 0.05}, 0, 0, 0), map);
  ASSERT_TRUE(result);
  EXPECT_EQ(result->rays, 64u * 48u);
  EXPECT_EQ(result->hits, 0u);
  EXPECT_EQ(map.state(Eigen::Vector3d{2.0, 0.05, 0.05}).empty_evidence,
            RayIntegratorConfig{}.miss_evidence);
}

TYPED_TEST(Integrators, ChangedNamesExactlyTheBricksWhoseClassesChanged) {
  VoxelMap map{0.05};
  TypeParam integrator{to_range(3)};
  std::mt19937 random{9};
  std::uniform_real_distribution<double> uniform{-1, 1};
  for (int frame = 0; frame < 6; ++frame) {
    const auto image =
        image_of(small_camera(96, 72), 1, [&](int, int) { return 2 + 0.3 * uniform(random); });
    std::map<BrickIndex, std::pair<VoxelMask, VoxelMask>> before;
    map.grid().for_each([&](BrickIndex index, const EvidenceBrick& brick) {
      before[index] = {brick.known, brick.occupied};
    });
    const auto result =
        integrator.integrate(image, pose({0, 0, 0.1 * frame}, 0, 0, 0.1 * frame), map);
    ASSERT_TRUE(result);
    std::vector<BrickIndex> expected;
    map.grid().for_each([&](BrickIndex index, const EvidenceBrick& brick) {
      if (before[index] != std::pair{brick.known, brick.occupied}) expected.push_back(index);
    });
    std::sort(expected.begin(), expected.end());
    EXPECT_EQ(result->changed, expected);
  }
}

TYPED_TEST(Integrators, RefusesWhatCannotBeAndLeavesTheMapAlone) {
  VoxelMap map{0.01};
  TypeParam integrator{to_range(3)};
  const auto good = image_of(small_camera(64, 48), 1, [](int, int) { return 2.0; });
  const Isometry T = pose({0, 0, 0}, 0, 0, 0);
  auto bad_size = good;
  bad_size.code.create(1, 1);
  auto bad_focal = good;
  bad_focal.camera.f_px = 0;
  auto bad_baseline = good;
  bad_baseline.camera.baseline_m = std::nan("");
  auto bad_step = good;
  bad_step.step_px = 0;
  for (const auto& image : {bad_size, bad_focal, bad_baseline, bad_step}) {
    const auto result = integrator.integrate(image, T, map);
    ASSERT_FALSE(result);
    EXPECT_NE(result.error().message.find("disparity image"), std::string::npos);
  }
  const double nan = std::nan("");
  EXPECT_FALSE(integrator.integrate(good, pose({nan, 0, 0}, 0, 0, 0), map));
  EXPECT_FALSE(integrator.integrate(good, pose({0, 0, 84000}, 0, 0, 0), map));
  EXPECT_EQ(map.brick_count(), 0u);
  EXPECT_TRUE(integrator.integrate(good, pose({0, 0, 83000}, 0, 0, 0), map));
}

}  // namespace
}  // namespace cairn::mapping
