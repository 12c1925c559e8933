// SPDX-License-Identifier: Apache-2.0
#include "simulation/reachable_floor.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "scenes.hpp"
#include "simulation/depth_renderer.hpp"

namespace cairn::simulation {
namespace {

/// A floor of 4 x 4 m inside walls, and what is put there.
World room_with(std::vector<BoxConfig> things) {
  things.push_back(box({0, 0, -0.1}, {4.4, 4.4, 0.2}));
  things.push_back(box({2.1, 0, 1}, {0.2, 4.4, 2}));
  things.push_back(box({-2.1, 0, 1}, {0.2, 4.4, 2}));
  things.push_back(box({0, 2.1, 1}, {4.4, 0.2, 2}));
  things.push_back(box({0, -2.1, 1}, {4.4, 0.2, 2}));
  return world_of(std::move(things));
}

ReachableFloor flood(const World& world, const Eigen::Vector2d& start_m = {-1.5, -1.5}) {
  auto floor = ReachableFloor::flood(world, start_m, {});
  EXPECT_TRUE(floor) << floor.error().message;
  return std::move(*floor);
}

TEST(ReachableFloor, OfAnEmptyRoomIsTheRoomButForRoundedCorners) {
  const auto floor = flood(room_with({}));
  const double radius_m = Walker{}.radius_m;
  // What a disc cannot reach in a corner: r^2 (1 - pi / 4).
  const double corners_m2 = 4 * radius_m * radius_m * (1 - std::numbers::pi / 4);
  EXPECT_NEAR(floor.area_m2(), 16 - corners_m2, 0.35);
  EXPECT_TRUE(floor.has_room_at({1.75, 0}));
  EXPECT_FALSE(floor.has_room_at({1.78, 0}));
  EXPECT_GE(floor.cell_at({1.95, 0}), 0);
  EXPECT_EQ(floor.cell_at({2.1, 0}), -1);
  EXPECT_EQ(floor.cell_at({50, 50}), -1);
  EXPECT_FALSE(floor.has_room_at({std::nan(""), 0}));
  for (const auto& cell : floor.cells()) EXPECT_NEAR(cell.middle_m.z(), 0, 1e-6);
  for (std::size_t i = 0; i < floor.cells().size(); ++i) {
    EXPECT_EQ(floor.cell_at(floor.cells()[i].middle_m.head<2>()), static_cast<int>(i));
  }
}

TEST(ReachableFloor, EndsAtAStepOfOverTwoCentimetresUpOrDown) {
  for (const auto& [height_m, reached] :
       {std::pair{0.015, true}, {0.019, true}, {0.022, false}, {0.15, false}}) {
    const World world = room_with({box({1, 0, height_m / 2}, {2, 4, height_m})});
    const auto up = flood(world);
    EXPECT_EQ(up.has_room_at({1, 0}), reached) << height_m;
    // A walker that starts on top finds its ground only where it is a step away from z = 0.
    if (!reached) continue;
    EXPECT_TRUE(flood(world, {1, 0}).has_room_at({-1, 0})) << height_m;
  }
}

TEST(ReachableFloor, GoesUpARampOfTenDegreesButNotOfFifteen) {
  for (const auto& [slope_deg, reached] : {std::pair{5.0, true}, {10.0, true}, {15.0, false}}) {
    // From x = -0.5 at z = 0 up to a platform that begins at x = 1.
    const double slope = slope_deg * std::numbers::pi / 180;
    const double top_m = 1.5 * std::tan(slope);
    const Eigen::Vector3d middle = Eigen::Vector3d(0.25, 0, top_m / 2) -
                                   0.05 * Eigen::Vector3d(-std::sin(slope), 0, std::cos(slope));
    const World world = room_with({box({middle.x(), middle.y(), middle.z()},
                                       {1.5 / std::cos(slope), 1.2, 0.1}, {0, -slope_deg, 0}),
                                   box({1.5, 0, top_m / 2}, {1, 4, top_m})});
    const auto floor = flood(world);
    EXPECT_EQ(floor.has_room_at({1.5, 0}), reached) << slope_deg;
    if (!reached) continue;
    EXPECT_NEAR(floor.cells()[static_cast<std::size_t>(floor.cell_at({1.5, 0}))].middle_m.z(),
                top_m, 1e-6);
    // Never over the platform's edge or the ramp's side.
    EXPECT_FALSE(floor.has_room_at({1.1, 1.5}));
    EXPECT_FALSE(floor.has_room_at({0.8, 0.6}));
  }
}

TEST(ReachableFloor, SeesThinLegsAndLowTablesButGoesUnderHighOnes) {
  const auto legs = flood(room_with({box({0, 0, 0.4}, {0.03, 0.03, 0.8})}));
  EXPECT_FALSE(legs.has_room_at({0.2, 0.1}));
  EXPECT_TRUE(legs.has_room_at({0.3, 0}));
  EXPECT_FALSE(flood(room_with({box({0, 0, 0.38}, {1, 1, 0.04})})).has_room_at({0, 0}));
  EXPECT_TRUE(flood(room_with({box({0, 0, 0.5}, {1, 1, 0.04})})).has_room_at({0, 0}));
}

TEST(ReachableFloor, GoesThroughGapsThatAreWideEnoughAndNoOthers) {
  for (const auto& [gap_m, reached] : {std::pair{0.44, false}, {0.52, true}}) {
    const double wall_m = (4 - gap_m) / 2;
    const World world = room_with({box({0, gap_m / 2 + wall_m / 2, 1}, {0.1, wall_m, 2}),
                                   box({0, -gap_m / 2 - wall_m / 2, 1}, {0.1, wall_m, 2})});
    EXPECT_EQ(flood(world).has_room_at({1, 0}), reached) << gap_m;
  }
}

TEST(ReachableFloor, AStartWithoutRoomIsRefused) {
  const World world = room_with({box({0, 0, 0.5}, {1, 1, 1})});
  for (const Eigen::Vector2d& start : {Eigen::Vector2d(0, 0), {0.6, 0}, {2.1, 0}, {50, 0}}) {
    const auto floor = ReachableFloor::flood(world, start, {});
    ASSERT_FALSE(floor) << start.transpose();
    EXPECT_EQ(floor.error().message.find("floor: nothing of radius 0.23"), 0U);
  }
}

struct Place {
  const char* world;
  double least_m2;
  double most_m2;
};

class FloorOf : public testing::TestWithParam<Place> {};

TEST_P(FloorOf, IsAsLargeAsThePlaceAndAllOfOnePiece) {
  const auto world = load_world(world_file(GetParam().world));
  ASSERT_TRUE(world) << world.error().message;
  const Eigen::Vector2d start = world->T_world_start.translation().head<2>();
  const auto floor = ReachableFloor::flood(*world, start, {});
  ASSERT_TRUE(floor) << floor.error().message;
  EXPECT_GE(floor->area_m2(), GetParam().least_m2);
  EXPECT_LE(floor->area_m2(), GetParam().most_m2);
  // What a robot of 0.8 m could reach is nearly all of it: no way is narrower.
  Walker wide;
  wide.radius_m = 0.4;
  const auto wider = ReachableFloor::flood(*world, start, wide);
  ASSERT_TRUE(wider) << wider.error().message;
  EXPECT_GE(wider->area_m2(), 0.85 * floor->area_m2());
}

TEST_P(FloorOf, HasSomethingToSeeWhereverARobotLooksFromIt) {
  const auto world = load_world(world_file(GetParam().world));
  ASSERT_TRUE(world) << world.error().message;
  const Eigen::Vector2d start = world->T_world_start.translation().head<2>();
  const auto floor = ReachableFloor::flood(*world, start, {});
  ASSERT_TRUE(floor) << floor.error().message;
  const auto depth = DepthRenderer::create(*world, simulated_rig());
  ASSERT_TRUE(depth) << depth.error().message;
  for (std::size_t i = 0; i < floor->cells().size(); i += floor->cells().size() / 60) {
    const Eigen::Vector3d& place_m = floor->cells()[i].middle_m;
    if (!floor->has_room_at(place_m.head<2>())) continue;
    for (int direction = 0; direction < 12; ++direction) {
      Isometry T = pose_2d(place_m.x(), place_m.y(), 0.5236 * direction);
      T.translation() = place_m;
      T.linear() *= rotation_from_rpy(0.1, direction % 2 == 0 ? 0.15 : -0.15, 0);
      ASSERT_EQ(cv::countNonZero(depth->left_m(T, 4) == 0), 0) << place_m.transpose();
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Worlds, FloorOf,
                         testing::Values(Place{"room", 20, 30}, Place{"apartment", 52, 80},
                                         Place{"office", 150, 200}, Place{"hand-drawn", 45, 60},
                                         Place{"symmetric-room", 15, 20}, Place{"plain", 28, 35}),
                         [](const auto& place) {
                           std::string name = place.param.world;
                           std::erase(name, '-');
                           return name;
                         });

}  // namespace
}  // namespace cairn::simulation
