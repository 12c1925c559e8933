// SPDX-License-Identifier: Apache-2.0
#include "mapping/ray_shortcuts.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/geometry.hpp"

namespace cairn::mapping {
namespace {

constexpr double kVoxel_m = 0.02;

/// The simulated robot's rays, all as long.
RayGrid robot_grid(double end_depth_m) {
  RayGrid grid;
  grid.f_px = 277;
  grid.cx_px = 159.5;
  grid.cy_px = 119.5;
  grid.end_depth_m = cv::Mat_<double>(240, 320, end_depth_m);
  return grid;
}

bool meets(const Eigen::Vector3d& direction, double end_depth_m, const Eigen::Matrix3d& R,
           const Eigen::Vector3d& middle_m) {
  const Eigen::Vector3d from = R.transpose() * -middle_m;
  const Eigen::Vector3d along = R.transpose() * direction * end_depth_m;
  double enter = 0;
  double leave = 1;
  for (int axis = 0; axis < 3; ++axis) {
    const double a = (-kVoxel_m / 2 - from[axis]) / along[axis];
    const double b = (kVoxel_m / 2 - from[axis]) / along[axis];
    enter = std::max(enter, std::min(a, b));
    leave = std::min(leave, std::max(a, b));
  }
  return leave > enter;
}

// Whatever voxel a spared ray meets in its spared part, however it is turned and wherever it is
// hit: brute force finds another ray, one that is not spared there, which meets it.
TEST(RayShortcuts, EveryVoxelThatARayIsSparedIsMetByOneThatIsNot) {
  constexpr unsigned kSeed = 3;
  std::mt19937 random(kSeed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  RayGrid grid = robot_grid(3);
  for (int i = 0; i < 300; ++i) grid.end_depth_m.begin()[random() % (240 * 320)] = 0;
  for (int row = 0; row < 240; ++row)
    for (int col = 200; col < 320; ++col) grid.end_depth_m(row, col) = 0.5 + 0.01 * (row % 7);
  RayShortcuts shortcuts;
  shortcuts.find(grid, kVoxel_m);
  const auto direction = [&](int row, int col) {
    return Eigen::Vector3d((col - grid.cx_px) / grid.f_px, (row - grid.cy_px) / grid.f_px, 1);
  };
  int tried = 0;
  while (tried < 3000) {
    const int row = static_cast<int>(random() % 240);
    const int col = static_cast<int>(random() % 320);
    const double from_m = RayShortcuts::kFromVoxels * kVoxel_m;
    const double until_m = shortcuts.until_m(row, col);
    if (grid.end_depth_m(row, col) == 0 || until_m <= from_m) continue;
    const double depth_m = from_m + (until_m - from_m) * 0.5 * (1 + uniform(random));
    // A voxel that has this point of the ray somewhere in it, as often as not at a corner.
    const Eigen::Matrix3d R =
        rotation_from_rpy(3 * uniform(random), 3 * uniform(random), 3 * uniform(random));
    Eigen::Vector3d within(uniform(random), uniform(random), uniform(random));
    if (tried % 2 == 0) within = within.cwiseSign() * 0.999;
    const Eigen::Vector3d middle_m = direction(row, col) * depth_m + R * within * kVoxel_m / 2;
    ++tried;
    bool met = false;
    for (int r = 0; r < 240 && !met; ++r) {
      for (int c = 0; c < 320 && !met; ++c) {
        const double end_m = grid.end_depth_m(r, c);
        const double farthest_m = middle_m.z() + 0.9 * kVoxel_m;
        if (end_m == 0 || shortcuts.until_m(r, c) > middle_m.z() - 0.9 * kVoxel_m) continue;
        met = end_m > farthest_m && meets(direction(r, c), end_m, R, middle_m);
      }
    }
    ASSERT_TRUE(met) << "seed " << kSeed << ", ray " << row << " " << col << " at " << depth_m;
  }
}

TEST(RayShortcuts, AFullGridIsSparedMostOfTheWayThatItsDensityAllows) {
  RayShortcuts shortcuts;
  shortcuts.find(robot_grid(4), kVoxel_m);
  double spared_m = 0;
  for (int row = 0; row < 240; ++row)
    for (int col = 0; col < 320; ++col) spared_m += shortcuts.until_m(row, col);
  // At 1.9 m every second ray of every second row is enough.
  EXPECT_GT(spared_m / (240 * 320), 1.3);
  EXPECT_EQ(shortcuts.until_m(112, 160), 0) << "a ray of the coarsest lattice";
}

TEST(RayShortcuts, RaysThatAreTooFarApartAreAllWalked) {
  RayShortcuts shortcuts;
  shortcuts.find(robot_grid(4), 0.001);
  for (int row = 0; row < 240; ++row)
    for (int col = 0; col < 320; ++col) EXPECT_LE(shortcuts.until_m(row, col), 0.1);
}

TEST(RayShortcuts, WhereNeighboursEndNearerNothingFartherIsSpared) {
  RayGrid grid = robot_grid(1);
  grid.end_depth_m(101, 101) = 4;
  RayShortcuts shortcuts;
  shortcuts.find(grid, kVoxel_m);
  EXPECT_LT(shortcuts.until_m(101, 101), 1);
  EXPECT_GT(shortcuts.until_m(101, 101), 0.9);
}

}  // namespace
}  // namespace cairn::mapping
