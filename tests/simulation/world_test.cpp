// SPDX-License-Identifier: Apache-2.0
#include "simulation/world.hpp"

#include <random>
#include <sstream>

#include "evaluation/corruption.hpp"
#include "evaluation/temporary_files.hpp"
#include "scenes.hpp"

namespace cairn::simulation {
namespace {

class WorldFile : public evaluation::TemporaryFiles {
 protected:
  std::string error_of(const std::string& yaml) const {
    const auto world = load_world(write("w.yaml", yaml));
    return world ? "no error" : world.error().message;
  }
  std::string name() const { return (folder_ / "w.yaml").string(); }
};

TEST(World, DistanceToATurnedBoxByHand) {
  // A cube of 2 m, turned by 45 degrees about z: its edge points along x, sqrt(2) from the middle.
  const World world = world_of({box({0, 0, 0}, {2, 2, 2}, {0, 0, 45})});
  EXPECT_NEAR(world.distance_m({3, 0, 0}), 3 - std::sqrt(2.0), 1e-12);           // to the edge
  EXPECT_NEAR(world.distance_m({0, 0, 1.5}), 0.5, 1e-12);                        // to the top
  EXPECT_NEAR(world.distance_m({std::sqrt(2.0), std::sqrt(2.0), 0}), 1, 1e-12);  // to a side
  EXPECT_NEAR(world.distance_m({0, 0, 0.75}), -0.25, 1e-12);                     // inside
  EXPECT_NEAR(world.distance_m({0, 0, 0}), -1, 1e-12);
}

TEST(World, TheNearestBoxCounts) {
  const World world = world_of({box({0, 0, 0}, {1, 1, 1}), box({5, 0, 0}, {1, 1, 1})});
  EXPECT_NEAR(world.distance_m({3.5, 0, 0}), 1, 1e-12);
}

TEST(World, PitchIsTheRobots) {
  // Pitch turns x towards -z: the box's long axis goes down ahead.
  const World world = world_of({box({0, 0, 0}, {4, 1, 0.1}, {0, 30, 0})});
  EXPECT_LT(world.distance_m({std::cos(0.5236), 0, -std::sin(0.5236)}), 0);
}

TEST(World, TheRoomThatShipsIsClosedAndHasRoomForARobot) {
  const auto room = load_world(room_file());
  ASSERT_TRUE(room) << room.error().message;
  EXPECT_GT(room->distance_m({-1, -1, 0.3}), 0.25);
  EXPECT_LT(room->distance_m({0, 0, -0.05}), 0);
  EXPECT_LT(room->distance_m({3.05, 0, 1}), 0);
  EXPECT_LT(room->distance_m({-2.7, 2.55, 2.45}), 0);
}

TEST_F(WorldFile, ErrorsNameFileLineAndKey) {
  const std::string good =
      "materials:\n  - {name: m}\nboxes:\n  - {centre_m: [0, 0, 0], size_m: [1, 1, 1], material: "
      "m}\n";
  EXPECT_EQ(error_of(good), "no error");
  EXPECT_EQ(error_of(good + "lampp_m: [1, 2, 3]\n").find(name() + ":5: lampp_m: unknown key"), 0U);
  EXPECT_EQ(error_of(good + "  - {centre_m: [0, 0], size_m: [1, 1, 1], material: m}\n")
                .find(name() + ":5: boxes[1].centre_m: is not a list of 3 numbers"),
            0U);
  EXPECT_EQ(error_of(good + "  - {centre_m: [0, 0, 0], size_m: [1, 0, 1], material: m}\n")
                .find(name() + ":5: boxes[1].size_m: "),
            0U);
  EXPECT_EQ(error_of(good + "  - {centre_m: [0, 0, 0], size_m: [1, 1, 1], material: glass}\n"),
            name() + ": boxes[1].material: 'glass' is not one of the materials");
  EXPECT_EQ(error_of(good + "  - {size_m: [1, 1, 1], material: m}\n"),
            name() + ": boxes[1].centre_m: is missing");
  EXPECT_EQ(error_of("materials: [{name: m}, {name: m}]"),
            name() + ": materials[1].name: 'm' stands here twice");
  EXPECT_EQ(error_of("materials: [{name: m, fine_m: 1, coarse_m: 0.5}]"),
            name() + ": materials[0].fine_m: is over coarse_m");
  EXPECT_EQ(error_of("ambient: 1"), name() + ": boxes: there are none");
  EXPECT_EQ(error_of("boxes: [").find(name() + ":"), 0U);
}

TEST_F(WorldFile, WallsStartAndPeopleAreCheckedToo) {
  const std::string good = "materials: [{name: m}]\nwalls:\n  - {from_m: [0, 0], to_m: [4, 0], ";
  EXPECT_EQ(error_of(good + "material: m, doors: [{at_m: 1}, {at_m: 2}]}"), "no error");
  EXPECT_EQ(error_of(good + "material: m, doors: [{at_m: 1}, {at_m: 1.8}]}")
                .find(name() + ": walls[0].doors[1].at_m: the opening does not fit"),
            0U);
  EXPECT_EQ(error_of(good + "material: m, doors: [{at_m: 3.8}]}")
                .find(name() + ": walls[0].doors[0].at_m: the opening does not fit"),
            0U);
  EXPECT_EQ(error_of(good + "material: m, doors: [{at_m: 2, height_m: 2.5}]}"),
            name() + ": walls[0].doors[0].height_m: is not below the wall's");
  EXPECT_EQ(error_of(good + "material: glass}"),
            name() + ": walls[0].material: 'glass' is not one of the materials");
  EXPECT_EQ(error_of("materials: [{name: m}]\nwalls: [{to_m: [1, 0], material: m}]"),
            name() + ": walls[0].from_m: is missing");
  EXPECT_EQ(error_of("materials: [{name: m}]\nwalls: [{from_m: [1, 0], to_m: [1, 0], material: m}]")
                .find(name() + ": walls[0].to_m: is less than"),
            0U);
  EXPECT_EQ(error_of(good + "material: m}\nstart: {at_m: [1]}\n")
                .find(name() + ":4: start.at_m: is not a list of 2 numbers"),
            0U);
  EXPECT_EQ(error_of(good + "material: m}\npeople: [{waypoints: [{at_m: [1, 1]}]}]\n"),
            name() + ": people[0].waypoints: are fewer than two");
  EXPECT_EQ(error_of(good + "material: m}\npeople: [{waypoints: [{at_m: [1, 1]}, {}]}]\n"),
            name() + ": people[0].waypoints[1].at_m: is missing");
}

TEST_F(WorldFile, ABoxThatLooksLikeAnotherMustBeAbleTo) {
  const std::string one =
      "materials: [{name: m}]\nboxes:\n  - {name: a, centre_m: [0, 0, 0], "
      "size_m: [1, 2, 3], material: m}\n";
  EXPECT_EQ(error_of(one + "  - {centre_m: [5, 0, 0], size_m: [1, 2, 3], looks_like: a}\n"),
            "no error");
  EXPECT_EQ(error_of(one + "  - {centre_m: [5, 0, 0], size_m: [1, 2, 3], looks_like: b}\n"),
            name() + ": boxes[1].looks_like: no box before this one is called 'b'");
  EXPECT_EQ(error_of(one + "  - {centre_m: [5, 0, 0], size_m: [1, 2, 4], looks_like: a}\n"),
            name() + ": boxes[1].looks_like: 'a' has another size");
  EXPECT_EQ(
      error_of(one + "  - {centre_m: [5, 0, 0], size_m: [1, 2, 3], looks_like: a, material: m}\n"),
      name() + ": boxes[1].material: stands beside looks_like");
  EXPECT_EQ(error_of(one + one.substr(one.find("  - ")) +
                     "  - {centre_m: [5, 0, 0], size_m: [1, 2, 3], looks_like: a}\n"),
            name() + ": boxes[2].looks_like: more than one box is called 'a'");
}

TEST_F(WorldFile, AWallIsSolidButForItsDoors) {
  // From (1, 1) to (1, 5), 10 cm thick, 2.5 m high; a door 1 m wide and 2 m high about y = 3.
  const auto world = load_world(write("w.yaml",
                                      "materials: [{name: m}]\nwalls: [{from_m: [1, 1], to_m: [1, "
                                      "5], material: m, doors: [{at_m: 2, width_m: 1}]}]"));
  ASSERT_TRUE(world) << world.error().message;
  EXPECT_NEAR(world->distance_m({1.25, 2, 1}), 0.2, 1e-9);
  EXPECT_NEAR(world->distance_m({1, 3, 1}), 0.5, 1e-9);
  EXPECT_NEAR(world->distance_m({1, 3, 1.9}), 0.1, 1e-9);
  EXPECT_LT(world->distance_m({1, 3, 2.2}), 0);
  EXPECT_NEAR(world->distance_m({1, 2, 2.7}), 0.2, 1e-9);
  EXPECT_NEAR(world->distance_m({1, 5.245, 1}), 0.2, 1e-9);
  EXPECT_NEAR(world->distance_m({1, 0.755, 1}), 0.2, 1e-9);
}

TEST_F(WorldFile, ReaderSurvivesCorruption) {
  std::stringstream drawn;
  drawn << std::ifstream(world_file("hand-drawn")).rdbuf();
  const std::string yaml = drawn.str();
  ASSERT_FALSE(yaml.empty());
  constexpr unsigned kSeed = 5;
  std::mt19937 random(kSeed);
  for (int trial = 0; trial < 2000; ++trial) {
    const auto world = load_world(write("w.yaml", evaluation::corrupted(yaml, random)));
    ASSERT_TRUE(world || !world.error().message.empty()) << "seed " << kSeed << " trial " << trial;
  }
}

}  // namespace
}  // namespace cairn::simulation
