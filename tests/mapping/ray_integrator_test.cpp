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
using testing::pose;
using testing::small_camera;
using testing::to_range;

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

void expect_same(const VoxelMap& map, const BruteForce& truth) {
  std::size_t with_evidence = 0;
  map.grid().for_each([&](BrickIndex, const EvidenceBrick& brick) {
    for (std::size_t i = 0; i < kBrickVoxels; ++i) {
      with_evidence +=
          brick.occupied_evidence.of[i] + brick.settled_empty_evidence.of[i] > 0 ? 1 : 0;
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

}  // namespace
}  // namespace cairn::mapping
