// SPDX-License-Identifier: Apache-2.0
#include "mapping/projective_integrator.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <set>

#include "mapping/made_images.hpp"
#include "mapping/ray_integrator.hpp"
#include "mapping/thread_time.hpp"

namespace cairn::mapping {
namespace {

using testing::image_of;
using testing::pose;
using testing::small_camera;
using testing::to_range;

constexpr double kResolution_m = 0.02;

/// The voxels that the used pixels end in.
std::set<VoxelIndex> ends(const stereo::DisparityImage& image, const Isometry& T_map_camera,
                          const VoxelMap& map) {
  std::set<VoxelIndex> voxels;
  for (int row = 0; row < image.rows(); ++row) {
    for (int col = 0; col < image.cols(); ++col) {
      if (!image.valid(row, col)) continue;
      const Eigen::Vector3d point = image.point_camera(row, col);
      if (point.norm() < 3) voxels.insert(map.voxel_at(T_map_camera * point));
    }
  }
  return voxels;
}

std::size_t count_of(const VoxelMap& map, const std::set<VoxelIndex>& voxels, VoxelClass wanted) {
  std::size_t count = 0;
  for (const VoxelIndex voxel : voxels) count += map.state(voxel).voxel_class == wanted ? 1 : 0;
  return count;
}

/// Drives forward 1 cm a frame over a floor 0.3 m below.
std::size_t floor_voxels_eaten(Integrator& integrator) {
  VoxelMap map{kResolution_m};
  std::set<VoxelIndex> floor;
  const auto image = image_of(small_camera(320, 240), 1, [](int row, int) {
    return row > 120 ? 0.3 * 320 / (row - 120) : 0.0;
  });
  for (int frame = 0; frame < 20; ++frame) {
    const Isometry T_map_camera = pose({0.01 * frame, 0.003, 0.307}, 0, 0, 0);
    EXPECT_TRUE(integrator.integrate(image, T_map_camera, map));
    floor.merge(ends(image, T_map_camera, map));
  }
  EXPECT_GT(floor.size(), 5000u);
  return count_of(map, floor, VoxelClass::kFree);
}

TEST(ProjectiveIntegrator, TheFloorAtGrazingAnglesIsNotEaten) {
  ProjectiveIntegrator projective{to_range(3)};
  RayIntegrator exact{to_range(3)};
  EXPECT_EQ(floor_voxels_eaten(projective), 0u);
  EXPECT_GT(floor_voxels_eaten(exact), 100u) << "which would mean that this test shows nothing";
}

TEST(ProjectiveIntegrator, AStickOfOnePixelBeforeAWallStaysAndTheWallBesideItToo) {
  ProjectiveIntegrator integrator{to_range(3)};
  VoxelMap map{kResolution_m};
  std::set<VoxelIndex> surface;
  for (int frame = 0; frame < 20; ++frame) {
    const double aside_m = 0.0005 * frame;
    const Isometry T_map_camera = pose({0.003, aside_m, 0.003}, 0, 0, 0);
    const int stick = 80 + static_cast<int>(std::lround(160 * aside_m / 1.0));
    const auto image =
        image_of(small_camera(160, 120), 1, [&](int, int col) { return col == stick ? 1.0 : 2.0; });
    EXPECT_TRUE(integrator.integrate(image, T_map_camera, map));
    if (frame < 18) surface.merge(ends(image, T_map_camera, map));
  }
  EXPECT_EQ(count_of(map, surface, VoxelClass::kFree), 0u);
  EXPECT_GT(count_of(map, surface, VoxelClass::kOccupied),
            0.95 * static_cast<double>(surface.size()));
}

TEST(ProjectiveIntegrator, AWallThatGivesNoMoreAnswersStays) {
  ProjectiveIntegrator integrator{to_range(3)};
  VoxelMap map{kResolution_m};
  const Isometry T_map_camera = pose({0, 0, 0}, 0, 0, 0.2);
  const auto wall = image_of(small_camera(160, 120), 1, [](int, int) { return 2.0; });
  for (int frame = 0; frame < 2; ++frame) {
    ASSERT_TRUE(integrator.integrate(wall, T_map_camera, map));
  }
  const std::size_t occupied = map.occupied_voxels();
  const std::size_t known = map.known_voxels();
  EXPECT_GT(occupied, 5000u);
  const auto plain = image_of(small_camera(160, 120), 1, [](int row, int col) {
    const bool on_wall = row > 20 && row < 100 && col > 30 && col < 130;
    return on_wall ? 0.0 : 2.0;
  });
  for (int frame = 0; frame < 50; ++frame) {
    ASSERT_TRUE(integrator.integrate(plain, T_map_camera, map));
  }
  EXPECT_EQ(map.occupied_voxels(), occupied);
  EXPECT_EQ(map.known_voxels(), known);
}

TEST(ProjectiveIntegrator, WhatHasGoneIsFreeSoonAfter) {
  ProjectiveIntegrator integrator{to_range(3)};
  VoxelMap map{kResolution_m};
  const Isometry T_map_camera = pose({0, 0, 0}, 0, 0, 0);
  const auto with = image_of(small_camera(160, 120), 1, [](int row, int col) {
    return row > 40 && row < 80 && col > 60 && col < 100 ? 1.0 : 2.0;
  });
  const auto without = image_of(small_camera(160, 120), 1, [](int, int) { return 2.0; });
  for (int frame = 0; frame < 5; ++frame)
    ASSERT_TRUE(integrator.integrate(with, T_map_camera, map));
  const VoxelIndex there = map.voxel_at({1.001, 0.01, 0.01});
  EXPECT_EQ(map.state(there).voxel_class, VoxelClass::kOccupied);
  int frames = 0;
  while (map.state(there).voxel_class != VoxelClass::kFree && frames < 100) {
    ASSERT_TRUE(integrator.integrate(without, T_map_camera, map));
    ++frames;
  }
  EXPECT_LE(frames, 12);  // 2 empty a frame against 20 occupied
}

// Single near pixels all over: their voxels lie in bricks that are free but for them, too.
TEST(ProjectiveIntegrator, AVoxelThatARayEndsInIsNeverFreedByTheSameFrame) {
  std::mt19937 random{3};
  std::uniform_real_distribution<double> uniform{0, 1};
  std::size_t in_free_bricks = 0;
  for (int frame = 0; frame < 12; ++frame) {
    ProjectiveIntegrator integrator{to_range(3)};
    VoxelMap map{kResolution_m};
    const auto image = image_of(small_camera(640, 480), 1, [&](int, int) {
      return uniform(random) < 2e-5 ? 1 + uniform(random) : 2.3;
    });
    const Isometry T_map_camera = pose({0.1, 0.2, 0.3}, 0.3 * frame, 0.2 * frame, 0.7 * frame);
    ASSERT_TRUE(integrator.integrate(image, T_map_camera, map));
    for (const VoxelIndex voxel : ends(image, T_map_camera, map)) {
      EXPECT_EQ(map.state(voxel).occupied_evidence, RayIntegratorConfig{}.hit_evidence);
      EXPECT_EQ(map.state(voxel).empty_evidence, 0);
    }
    map.grid().for_each([&](BrickIndex, const EvidenceBrick& brick) {
      const VoxelMask empty = brick.empty_evidence().at_least(1);
      const VoxelMask hit = brick.occupied_evidence.at_least(1);
      in_free_bricks += hit.any() && empty.count() + hit.count() == kBrickVoxels ? 1 : 0;
    });
  }
  EXPECT_GT(in_free_bricks, 0u) << "which would mean that this test shows nothing";
}

// A forged focal length: a view of hundreds of metres beside the camera.
TEST(ProjectiveIntegrator, AnAbsurdCameraCostsNotMuchMoreThanAnyOther) {
  const auto cost_ms = [](double f_px) {
    ProjectiveIntegrator integrator{to_range(2)};
    VoxelMap map{0.01};
    auto image = image_of(small_camera(320, 240), 1, [](int, int) { return 5.0; });
    image.camera.f_px = f_px;
    image.camera.baseline_m = 80 / f_px;
    const double before_ms = testing::thread_ms();
    EXPECT_TRUE(integrator.integrate(image, pose({0, 0, 0}, 0, 0, 0), map));
    return testing::thread_ms() - before_ms;
  };
  EXPECT_LT(cost_ms(1), 50 * cost_ms(320));
}

// Lazy counts leave no trace: a map that was read back from what the first one would write and one
// that never stopped go on alike.
TEST(ProjectiveIntegrator, EvidenceOfFreeBricksAddsUpAsThatOfSingleVoxelsDoes) {
  ProjectiveIntegrator integrator{to_range(3)};
  VoxelMap map{kResolution_m};
  const Isometry T_map_camera = pose({0, 0, 0}, 0.1, 0.2, 0.3);
  const auto image = image_of(small_camera(160, 120), 1, [](int, int) { return 2.0; });
  constexpr int kFrames = 130;
  for (int frame = 0; frame < kFrames; ++frame)
    ASSERT_TRUE(integrator.integrate(image, T_map_camera, map));
  VoxelMap once{kResolution_m};
  ASSERT_TRUE(integrator.integrate(image, T_map_camera, once));
  std::size_t lazy = 0;
  once.grid().for_each([&](BrickIndex index, const EvidenceBrick& brick) {
    const EvidenceBrick& all = *map.grid().find(index);
    lazy += all.pending_empty_evidence > 0 ? 1 : 0;
    for (std::size_t i = 0; i < kBrickVoxels; ++i) {
      const auto times = [](int evidence) { return std::min(255, kFrames * evidence); };
      ASSERT_EQ(all.empty_evidence().of[i], times(brick.empty_evidence().of[i]));
      ASSERT_EQ(all.occupied_evidence.of[i], times(brick.occupied_evidence.of[i]));
    }
  });
  EXPECT_GT(lazy, 100u);
  EXPECT_EQ(map.brick_count(), once.brick_count());
}

}  // namespace
}  // namespace cairn::mapping
