// SPDX-License-Identifier: Apache-2.0
#include "simulation/texture_share.hpp"

#include <gtest/gtest.h>

#include "scenes.hpp"

namespace cairn::simulation {
namespace {

/// A closed room of 4 x 4 m whose every surface has this contrast.
World cube(double noise_contrast) {
  WorldConfig config;
  config.materials.emplace_back().name = "stuff";
  config.materials[0].noise_contrast = noise_contrast;
  config.materials[0].fine_m = 0.0025;
  config.materials[0].coarse_m = 0.16;
  config.materials[0].patches_per_m2 = 0;
  config.boxes = {box({0, 0, -0.1}, {4.4, 4.4, 0.2}),   box({0, 0, 2.6}, {4.4, 4.4, 0.2}),
                  box({2.1, 0, 1.25}, {0.2, 4.4, 2.5}), box({-2.1, 0, 1.25}, {0.2, 4.4, 2.5}),
                  box({0, 2.1, 1.25}, {4, 0.2, 2.5}),   box({0, -2.1, 1.25}, {4, 0.2, 2.5})};
  return make_world(config, "cube").value();
}

double share(const World& world, int places = 3) {
  TextureConfig config;
  config.places = places;
  const auto found = textureless_share(world, simulated_rig(), config);
  EXPECT_TRUE(found) << found.error().message;
  return *found;
}

TEST(TextureShare, IsAllOfABareRoomAndNothingOfARoughOne) {
  EXPECT_GT(share(cube(0)), 0.85);  // only where wall meets wall is there something to see
  EXPECT_LT(share(cube(0.3)), 0.005);
  EXPECT_GT(share(cube(0.02)), share(cube(0.05)));
}

struct Limits {
  const char* world;
  double least;
  double most;
};

class TextureOf : public testing::TestWithParam<Limits> {};

TEST_P(TextureOf, TheWorldsThatShip) {
  const auto world = load_world(world_file(GetParam().world));
  ASSERT_TRUE(world) << world.error().message;
  const double found = share(*world, 20);
  RecordProperty("textureless", std::to_string(found));
  EXPECT_GE(found, GetParam().least);
  EXPECT_LE(found, GetParam().most);
}

INSTANTIATE_TEST_SUITE_P(Worlds, TextureOf,
                         testing::Values(Limits{"room", 0, 0.03}, Limits{"apartment", 0, 0.03},
                                         Limits{"office", 0, 0.03}, Limits{"hand-drawn", 0, 0.03},
                                         Limits{"symmetric-room", 0, 0.03},
                                         Limits{"plain", 0.3, 1}),
                         [](const auto& limits) {
                           std::string name = limits.param.world;
                           std::erase(name, '-');
                           return name;
                         });

}  // namespace
}  // namespace cairn::simulation
