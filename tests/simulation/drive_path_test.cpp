// SPDX-License-Identifier: Apache-2.0
#include "simulation/drive_path.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "scenes.hpp"

namespace cairn::simulation {
namespace {

TEST(DriveRound, StartsAndEndsStandingAtTheSamePlace) {
  const auto path = drive_round(room_tour_m(), {});
  ASSERT_GT(path.size(), 60U);
  EXPECT_LT((path.front().T.translation() - path.back().T.translation()).norm(), 1e-9);
  EXPECT_LT(rotation_angle_rad(path.front().T.linear().transpose() * path.back().T.linear()), 0.01);
  EXPECT_LT((path[1].T.translation() - path[0].T.translation()).norm(), 0.5 * 1.0 / 15 / 15 + 1e-6);
}

TEST(DriveRound, KeepsToItsSpeedAndAcceleration) {
  const DriveConfig config{0.5, 0.4, 20};
  const auto path = drive_round(room_tour_m(), config);
  double last_mps = 0;
  for (std::size_t i = 1; i < path.size(); ++i) {
    EXPECT_EQ(path[i].utime, std::llround(static_cast<double>(i) * 1e6 / 20));
    const double mps = (path[i].T.translation() - path[i - 1].T.translation()).norm() * 20;
    EXPECT_LT(mps, 0.5 + 1e-6);
    EXPECT_LT(std::abs(mps - last_mps) * 20, 0.4 + 0.05);
    last_mps = mps;
  }
  // Way / speed, and speed / acceleration for the ramps.
  const double way_m = evaluation::path_length_m(path);
  EXPECT_NEAR(to_seconds(path.back().utime), way_m / 0.5 + 0.5 / 0.4, 0.1);
}

TEST(DriveRound, LooksWhereItGoes) {
  const auto path = drive_round(room_tour_m(), {});
  for (std::size_t i = 20; i + 20 < path.size(); ++i) {
    const Eigen::Vector3d step = path[i + 1].T.translation() - path[i].T.translation();
    const Eigen::Vector3d ahead =
        (path[i].T.linear().col(0) + path[i + 1].T.linear().col(0)).normalized();
    EXPECT_GT(step.normalized().dot(ahead), 0.9999) << i;
  }
}

TEST(DriveRound, TheTourOfTheRoomTouchesNothing) {
  const auto room = load_world(room_file());
  ASSERT_TRUE(room) << room.error().message;
  for (const auto& pose : drive_round(room_tour_m(), {})) {
    for (const double z_m : {0.25, 0.5, 1.0}) {
      EXPECT_GT(room->distance_m(pose.T * Eigen::Vector3d(0, 0, z_m)), 0.24);
    }
  }
}

}  // namespace
}  // namespace cairn::simulation
