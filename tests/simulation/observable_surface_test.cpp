// SPDX-License-Identifier: Apache-2.0
#include "simulation/observable_surface.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "scenes.hpp"
#include "simulation/drive_path.hpp"
#include "slab_ray.hpp"

namespace cairn::simulation {
namespace {

TEST(ObservableSurface, AWallAheadIsCoveredOncePerCell) {
  // The wall's face is 2 m ahead of the cameras and fills the view: each camera sees 2 * 2 * tan(30
  // degrees) = 2.31 m by 1.73 m of it; both share 2.31 - 0.254 m.
  const World world = world_of({box({2.6, 0, 0}, {1, 20, 20})});
  const ObservableConfig config{0.02, 0, 3, 1};
  const evaluation::Trajectory path{{0, Isometry::Identity()}};
  const auto points = observable_surface(world, test_rig(), path, config);
  ASSERT_TRUE(points) << points.error().message;
  const double width_m = 4 * std::tan(3.14159265358979323846 / 6);
  const double expected = (width_m - 0.254) * width_m * 0.75 / (0.02 * 0.02);
  EXPECT_NEAR(static_cast<double>(points->size()), expected, 0.04 * expected);
  for (const Eigen::Vector3d& point : *points) EXPECT_NEAR(point.x(), 2.1, 1e-9);
}

TEST(ObservableSurface, OfTheRoomIsSeenByBothCamerasFromSomewhereInRange) {
  const auto world = load_world(room_file());
  ASSERT_TRUE(world) << world.error().message;
  const auto rig = test_rig(320, 240);
  const ObservableConfig config{0.02, 0.5, 2.5, 1};
  evaluation::Trajectory path;
  const auto tour = drive_round(room_tour_m(), {});
  for (std::size_t i = 0; i < tour.size(); i += 30) path.push_back(tour[i]);
  const auto points = observable_surface(*world, rig, path, config);
  ASSERT_TRUE(points) << points.error().message;
  ASSERT_GT(points->size(), 1000U);
  int unseen = 0;
  for (std::size_t i = 0; i < points->size(); i += 7) {
    const Eigen::Vector3d& point = (*points)[i];
    ASSERT_NEAR(world->distance_m(point), 0, 1e-9);
    const auto seen_from = [&](const Isometry& T_world_eye) {
      const Eigen::Vector3d in_eye = T_world_eye.inverse() * point;
      const double u = rig.left.cx_px + rig.left.fx_px * in_eye.x() / in_eye.z();
      const double v = rig.left.cy_px + rig.left.fy_px * in_eye.y() / in_eye.z();
      // A cell's middle may lie 1.5 cm off the ray that found the cell: some 8 pixels at half a
      // metre.
      return in_eye.z() > 0 && u > -9 && u < 328 && v > -9 && v < 248 &&
             first_hit(*world, T_world_eye.translation(), point - T_world_eye.translation()) > 0.99;
    };
    const bool seen = std::any_of(path.begin(), path.end(), [&](const auto& pose) {
      const Isometry T_world_left = pose.T * rig.T_body_left;
      const double range_m = (point - T_world_left.translation()).norm();
      return range_m > 0.48 && range_m < 2.52 && seen_from(T_world_left) &&
             seen_from(T_world_left * rig.T_right_left.inverse());
    });
    unseen += !seen;
  }
  EXPECT_EQ(unseen, 0);
}

TEST(ObservableSurface, IsTheSameEveryTime) {
  const auto world = load_world(room_file());
  ASSERT_TRUE(world) << world.error().message;
  const evaluation::Trajectory path{{0, pose_2d(0, -1, 0)}, {1, pose_2d(0, -1, 1)}};
  const auto once = observable_surface(*world, test_rig(160, 120), path, {});
  const auto again = observable_surface(*world, test_rig(160, 120), path, {});
  ASSERT_TRUE(once && again);
  EXPECT_EQ(*once, *again);
}

}  // namespace
}  // namespace cairn::simulation
