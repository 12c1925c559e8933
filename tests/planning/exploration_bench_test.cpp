// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cstdio>

#include "explorer_bench.hpp"

namespace cairn::testing {
namespace {

simulation::World world_of(const std::string& name) {
  return simulation::load_world(std::string(CAIRN_SOURCE_DIR) + "/config/worlds/" + name).value();
}

void tell(const ExplorerBench& bench) {
  std::printf("%.1f s, %.1f m, coverage %.3f, collisions %d\n", bench.time_s(), bench.driven_m(),
              bench.coverage(), static_cast<int>(bench.collisions()));
}

TEST(ExplorerBench, ExploresTheFurnishedRoom) {
  ExplorerBench bench(world_of("room.yaml"), {});
  bench.navigator().explore(0);
  bench.run(240);
  tell(bench);
  EXPECT_TRUE(bench.navigator().idle());
  EXPECT_EQ(bench.navigator().report().phase, planning::Phase::kArrived);
  EXPECT_GE(bench.coverage(), 0.95) << bench.story();
  EXPECT_EQ(bench.collisions(), 0) << bench.story();
  EXPECT_LE(bench.time_s(), 100) << bench.story();
}

// Not seen to hold yet, and takes minutes of processor time. Run it with
// --gtest_also_run_disabled_tests.
TEST(ExplorerBench, DISABLED_ExploresTheApartment) {
  ExplorerBench bench(world_of("apartment.yaml"), {});
  bench.navigator().explore(0);
  bench.run(600);
  tell(bench);
  EXPECT_TRUE(bench.navigator().idle());
  EXPECT_EQ(bench.navigator().report().phase, planning::Phase::kArrived);
  EXPECT_GE(bench.coverage(), 0.90) << bench.story();
  EXPECT_EQ(bench.collisions(), 0) << bench.story();
  EXPECT_LE(bench.time_s(), 360) << bench.story();
}

}  // namespace
}  // namespace cairn::testing
