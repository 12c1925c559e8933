// SPDX-License-Identifier: Apache-2.0
#include "planning/plan_memory.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace cairn::planning {
namespace {

PlanMemory some_memory() {
  PlanMemory memory;
  memory.mission = Mission::kExplore;
  memory.goal_id = 77;
  memory.destination = {{1.5, -2.25}, 0.5};
  memory.looked_round = true;
  memory.phase = Phase::kRecovering;
  memory.reason = "does not get on";
  memory.floor = {{{0, 0}, 0.8, 0.01}, {{0.1, -0.2}, 0.15, -0.01}};
  memory.looks = {{{3, -4}, 1}, {{-5, 6}, 2}};
  return memory;
}

TEST(PlanMemory, ComesBackAsItWas) {
  const auto bytes = to_bytes(some_memory());
  const auto back = plan_memory_from_bytes(bytes);
  ASSERT_TRUE(back) << back.error().message;
  EXPECT_EQ(to_bytes(*back), bytes);
  EXPECT_EQ(back->mission, Mission::kExplore);
  EXPECT_EQ(back->reason, "does not get on");
  EXPECT_EQ(back->floor.size(), 2U);
  EXPECT_EQ(back->looks, some_memory().looks);
  EXPECT_EQ(back->destination.heading_rad, 0.5);
}

TEST(PlanMemory, DamageIsRefusedOrHarmless) {
  const auto whole = to_bytes(some_memory());
  constexpr unsigned kSeed = 41;
  SCOPED_TRACE(kSeed);
  std::mt19937 random(kSeed);
  int refused = 0;
  for (int i = 0; i < 5000; ++i) {
    auto bytes = whole;
    for (auto hits = 1 + random() % 3; hits > 0; --hits) {
      if (random() % 5 == 0) bytes.resize(random() % (bytes.size() + 8));
      if (!bytes.empty()) bytes[random() % bytes.size()] = static_cast<std::uint8_t>(random());
    }
    const auto back = plan_memory_from_bytes(bytes);
    if (!back) {
      ++refused;
      continue;
    }
    for (const KnownFloor& floor : back->floor) {
      ASSERT_TRUE(floor.at_m.allFinite() && std::isfinite(floor.radius_m));
      ASSERT_LE(std::abs(floor.radius_m), 5);
    }
    ASSERT_LE(static_cast<int>(back->mission), 2);
    ASSERT_LE(static_cast<int>(back->phase), 5);
  }
  EXPECT_GT(refused, 1000);
}

}  // namespace
}  // namespace cairn::planning
