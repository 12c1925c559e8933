// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cstdio>

#include "explorer_bench.hpp"

namespace cairn::testing {
namespace {

simulation::World world_of(const std::string& name) {
  return simulation::load_world(std::string(CAIRN_SOURCE_DIR) + "/config/worlds/" + name).value();
}

std::string joined(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += line + "\n";
  return text;
}

void tell(const ExplorerBench& bench) {
  std::printf("%.1f s, %.1f m, coverage %.3f, touches %d\n", bench.time_s(), bench.driven_m(),
              bench.coverage(), bench.touches());
}

TEST(ExplorerBench, ExploresTheFurnishedRoom) {
  ExplorerBench bench(world_of("room.yaml"), {});
  bench.navigator().explore(0);
  bench.run(240);
  tell(bench);
  EXPECT_TRUE(bench.navigator().idle());
  EXPECT_EQ(bench.navigator().report().phase, planning::Phase::kArrived);
  EXPECT_GE(bench.coverage(), 0.95) << joined(bench.diary());
  EXPECT_EQ(bench.touches(), 0) << joined(bench.diary());
  EXPECT_LE(bench.time_s(), 100) << joined(bench.diary());
}

// Not reached yet: after 600 s it has seen 78 % and goes on. Run it with
// --gtest_also_run_disabled_tests.
TEST(ExplorerBench, DISABLED_ExploresTheApartment) {
  ExplorerBench bench(world_of("apartment.yaml"), {});
  bench.navigator().explore(0);
  bench.run(600);
  tell(bench);
  EXPECT_TRUE(bench.navigator().idle());
  EXPECT_EQ(bench.navigator().report().phase, planning::Phase::kArrived);
  EXPECT_GE(bench.coverage(), 0.90) << joined(bench.diary());
  EXPECT_EQ(bench.touches(), 0) << joined(bench.diary());
  EXPECT_LE(bench.time_s(), 360) << joined(bench.diary());
}

}  // namespace
}  // namespace cairn::testing
