// SPDX-License-Identifier: Apache-2.0
#include "mapping/ray_integrator.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <set>

#include "mapping/made_images.hpp"

namespace cairn::mapping {
namespace {

using testing::image_of;
using testing::small_camera;

constexpr double kResolution_m = 0.1;

/// Counts kept the plainest way: for each ray, every voxel of its bounding box is asked whether the
/// segment's part in it is longer than nothing (slabs, Kay and Kajiya 1986). No walking.
class BruteForce {
 public:
  explicit BruteForce(const RayIntegratorConfig& config) : config_{config} {}

  void integrate(const stereo::DisparityImage& image, const Isometry& T_map_camera) {
    std::set<VoxelIndex> hits;
    std::set<VoxelIndex> passed;
    for (int row = 0; row < image.rows(); ++row) {
      for (int col = 0; col < image.cols(); ++col) {
        if (!image.valid(row, col) || image.code(row, col) < config_.min_confidence) continue;
        const Eigen::Vector3d point = image.point_camera(row, col);
        if (point.norm() < config_.min_range_m) continue;
        const bool hit = point.norm() <= config_.max_range_m;
        const Eigen::Vector3d end = hit ? point : point.normalized() * config_.max_range_m;
        pass(T_map_camera.translation() / kResolution_m, T_map_camera * end / kResolution_m,
             passed);
        if (hit) hits.insert(voxel_around(T_map_camera * end / kResolution_m));
      }
    }
    for (const VoxelIndex voxel : hits) add(evidence[voxel].first, config_.hit_evidence);
    for (const VoxelIndex voxel : passed) {
      if (!hits.contains(voxel)) add(evidence[voxel].second, config_.miss_evidence);
    }
  }

  std::map<VoxelIndex, std::pair<int, int>> evidence;  ///< occupied, empty

 private:
  static void add(int& counter, int increment) { counter = std::min(255, counter + increment); }

  static VoxelIndex voxel_around(const Eigen::Vector3d& p) {
    return {static_cast<int>(std::floor(p.x())), static_cast<int>(std::floor(p.y())),
            static_cast<int>(std::floor(p.z()))};
  }

  static void pass(const Eigen::Vector3d& from, const Eigen::Vector3d& to,
                   std::set<VoxelIndex>& passed) {
    const VoxelIndex low = voxel_around(from.cwiseMin(to));
    const VoxelIndex high = voxel_around(from.cwiseMax(to));
    for (int x = low.x; x <= high.x; ++x) {
      for (int y = low.y; y <= high.y; ++y) {
        for (int z = low.z; z <= high.z; ++z) {
          if (length_inside(from, to, Eigen::Vector3d(x, y, z)) > 1e-10) passed.insert({x, y, z});
        }
      }
    }
  }

  /// Share of the segment inside the voxel whose lowest corner this is.
  static double length_inside(const Eigen::Vector3d& from, const Eigen::Vector3d& to,
                              const Eigen::Vector3d& corner) {
    double enter = 0;
    double leave = 1;
    for (int axis = 0; axis < 3; ++axis) {
      const double a = (corner[axis] - from[axis]) / (to[axis] - from[axis]);
      const double b = (corner[axis] + 1 - from[axis]) / (to[axis] - from[axis]);
      enter = std::max(enter, std::min(a, b));
      leave = std::min(leave, std::max(a, b));
    }
    return leave - enter;
  }

  RayIntegratorConfig config_;
};

Isometry pose(const Eigen::Vector3d& position_m, double roll, double pitch, double yaw) {
  Isometry T = Isometry::Identity();
  T.linear() = rotation_from_rpy(roll, pitch, yaw) * R_body_camera_forward();
  T.translation() = position_m;
  return T;
}

RayIntegratorConfig to_range(double max_range_m) {
  RayIntegratorConfig config;
  config.max_range_m = max_range_m;
  return config;
}

void expect_same(const VoxelMap& map, const BruteForce& truth) {
  std::size_t with_evidence = 0;
  map.grid().for_each([&](BrickIndex, const EvidenceBrick& brick) {
    for (std::size_t i = 0; i < kBrickVoxels; ++i) {
      with_evidence += brick.occupied_evidence[i] + brick.empty_evidence[i] > 0 ? 1 : 0;
    }
  });
  EXPECT_EQ(with_evidence, truth.evidence.size());
  for (const auto& [voxel, evidence] : truth.evidence) {
    const VoxelState state = map.state(voxel);
    ASSERT_EQ(state.occupied_evidence, evidence.first)
        << voxel.x << " " << voxel.y << " " << voxel.z;
    ASSERT_EQ(state.empty_evidence, evidence.second) << voxel.x << " " << voxel.y << " " << voxel.z;
  }
}

TEST(RayIntegrator, GivesEveryVoxelTheEvidenceThatBruteForceGives) {
  const unsigned seed = 7;
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937 random{seed};
  std::uniform_real_distribution<double> uniform{-1, 1};
  std::size_t compared = 0;
  for (int scene = 0; scene < 6; ++scene) {
    RayIntegratorConfig config = to_range(2.5);
    config.min_range_m = 0.6;
    config.hit_evidence = 100;  // three hits saturate
    config.miss_evidence = 50;
    RayIntegrator integrator{config};
    BruteForce truth{config};
    VoxelMap map{kResolution_m};
    for (int frame = 0; frame < 4; ++frame) {
      auto image = image_of(small_camera(48, 36), 2, [&](int row, int col) {
        if ((row + col) % 11 == 0) return 0.0;
        return 1.6 + 1.2 * uniform(random) + 0.02 * row;
      });
      image.code(5, 5) = 0;
      // Some near the origin, where all signs meet, some about the corner of a tile.
      const Eigen::Vector3d corner =
          scene % 2 == 0 ? Eigen::Vector3d::Zero() : Eigen::Vector3d{-12.8, 12.8, 0};
      const Eigen::Vector3d shift{uniform(random), uniform(random), uniform(random)};
      const double yaw = M_PI * uniform(random);
      const Isometry T_map_camera =
          pose(corner + 0.8 * shift, uniform(random), 1.5 * uniform(random), yaw);
      const auto result = integrator.integrate(image, T_map_camera, map);
      ASSERT_TRUE(result) << result.error().message;
      truth.integrate(image, T_map_camera);
    }
    expect_same(map, truth);
    compared += truth.evidence.size();
  }
  EXPECT_GT(compared, 20000u);
}

// Rays so close that most of them are spared most of their way, with holes in between.
TEST(RayIntegrator, SparesRaysOnlyWhatBruteForceFindsMarkedAllTheSame) {
  const unsigned seed = 11;
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937 random{seed};
  std::uniform_real_distribution<double> uniform{-1, 1};
  for (int scene = 0; scene < 4; ++scene) {
    const RayIntegratorConfig config = to_range(2.5);
    RayIntegrator integrator{config};
    BruteForce truth{config};
    VoxelMap map{kResolution_m};
    for (int frame = 0; frame < 3; ++frame) {
      const double hole_row = 24 + 20 * uniform(random);
      const double hole_col = 32 + 30 * uniform(random);
      auto image = image_of(small_camera(256, 192), 4, [&](int row, int col) {
        if (std::hypot(row - hole_row, col - hole_col) < 4 || random() % 300 == 0) return 0.0;
        return 1.9 + 0.8 * std::sin(0.1 * row * scene) + 0.01 * col;
      });
      const Isometry T_map_camera =
          pose({uniform(random), uniform(random), uniform(random)}, uniform(random),
               1.5 * uniform(random), M_PI * uniform(random));
      ASSERT_TRUE(integrator.integrate(image, T_map_camera, map));
      truth.integrate(image, T_map_camera);
    }
    expect_same(map, truth);
  }
}

TEST(RayIntegrator, AWallIsOccupiedFreeBeforeAndUnknownBehind) {
  // From x = 0.02 a wall 2 m ahead lies in the voxels [2.00, 2.05).
  constexpr double kRes_m = 0.05;
  VoxelMap map{kRes_m};
  RayIntegrator integrator{to_range(3)};
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

TEST(RayIntegrator, AHitWinsOverTheRaysThatPassThroughTheSameVoxel) {
  // Every other pixel sees a wall at 2 m, the rest look past it.
  VoxelMap map{0.2};
  RayIntegrator integrator{to_range(4)};
  const auto image = image_of(small_camera(64, 48), 1,
                              [](int row, int col) { return (row + col) % 2 == 0 ? 2.0 : 3.2; });
  ASSERT_TRUE(integrator.integrate(image, pose({0.1, 0.1, 0.1}, 0, 0, 0), map));
  const VoxelState wall = map.state(Eigen::Vector3d{2.1, 0.1, 0.1});
  EXPECT_EQ(wall.occupied_evidence, RayIntegratorConfig{}.hit_evidence);
  EXPECT_EQ(wall.empty_evidence, 0);
  const VoxelState between = map.state(Eigen::Vector3d{2.7, 0.1, 0.1});
  EXPECT_EQ(between.occupied_evidence, 0);
  EXPECT_EQ(between.empty_evidence, RayIntegratorConfig{}.miss_evidence);
}

TEST(RayIntegrator, BeyondMaxRangeFreesTheWayThereAndHitsNothing) {
  VoxelMap map{0.1};
  RayIntegrator integrator{to_range(3)};
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

TEST(RayIntegrator, PixelsWithoutAnAnswerTooNearOrOfLowConfidenceSayNothing) {
  VoxelMap map{0.1};
  RayIntegratorConfig config = to_range(3);
  config.min_range_m = 1;
  config.min_confidence = 2;
  RayIntegrator integrator{config};
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

TEST(RayIntegrator, DisparityAtInfinityFreesUpToMaxRange) {
  VoxelMap map{0.1};
  RayIntegrator integrator{to_range(3)};
  auto image = image_of(small_camera(64, 48), 1, [](int, int) { return 80.0; });
  image.camera.doffs_px = -2;  // disparity 1 less 2
  const auto result = integrator.integrate(image, pose({0.05, 0.05, 0.05}, 0, 0, 0), map);
  ASSERT_TRUE(result);
  EXPECT_EQ(result->rays, 64u * 48u);
  EXPECT_EQ(result->hits, 0u);
  EXPECT_EQ(map.state(Eigen::Vector3d{2.0, 0.05, 0.05}).empty_evidence,
            RayIntegratorConfig{}.miss_evidence);
}

TEST(RayIntegrator, ChangedNamesExactlyTheBricksWhoseClassesChanged) {
  VoxelMap map{0.05};
  RayIntegrator integrator{to_range(3)};
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

TEST(RayIntegrator, RefusesWhatCannotBeAndLeavesTheMapAlone) {
  VoxelMap map{0.01};
  RayIntegrator integrator{to_range(3)};
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
