// SPDX-License-Identifier: Apache-2.0
#include "procs/supervisor/group_life.hpp"

#include <gtest/gtest.h>

namespace cairn {
namespace {

using Action = ProcessLife::Action;

/// stereo, mapper, and a camera that waits for both.
GroupConfig group() {
  GroupConfig config;
  config.processes.resize(3);
  config.processes[0].name = "stereo";
  config.processes[1].name = "mapper";
  config.processes[2].name = "camera";
  config.processes[2].after = {"stereo", "mapper"};
  return config;
}

constexpr std::size_t kStereo = 0;
constexpr std::size_t kMapper = 1;
constexpr std::size_t kCamera = 2;
constexpr HostTime kStart = 1'000'000'000;

/// Starts what is due; its names.
std::string start_due(GroupLife& life, HostTime now_us) {
  std::string names;
  for (std::size_t i = 0; i < life.size(); ++i) {
    if (life.next(i, now_us) != Action::kStart) continue;
    life.life(i).started(now_us);
    names += life.name(i) + " ";
  }
  return names;
}

TEST(GroupLife, StartsAllAtOnceButThoseThatWaitUntilOthersAreReady) {
  GroupLife life(group(), {});
  EXPECT_EQ(start_due(life, kStart), "stereo mapper ");
  EXPECT_EQ(life.reason(kCamera, kStart), "waits for stereo, mapper");
  life.life(kStereo).heard(kStart, true, "");
  life.life(kMapper).heard(kStart, false, "");
  EXPECT_EQ(start_due(life, kStart + 20'000), "");
  EXPECT_EQ(life.reason(kCamera, kStart), "waits for mapper");
  life.life(kMapper).heard(kStart + 30'000, true, "");
  EXPECT_EQ(start_due(life, kStart + 40'000), "camera ");
}

TEST(GroupLife, OneThatDiedWaitsForNobody) {
  GroupLife life(group(), {});
  start_due(life, kStart);
  life.life(kStereo).heard(kStart, true, "");
  life.life(kMapper).heard(kStart, true, "");
  start_due(life, kStart);
  life.life(kCamera).ended(kStart + 10'000'000, -9);
  life.life(kStereo).ended(kStart + 10'000'000, -9);
  EXPECT_EQ(start_due(life, kStart + 10'300'000), "stereo camera ");
}

TEST(GroupLife, NobodyWaitsForOneThatIsNotWanted) {
  GroupConfig config = group();
  config.processes[kMapper].at_start = false;
  GroupLife life(config, {});
  EXPECT_EQ(start_due(life, kStart), "stereo ");
  EXPECT_EQ(life.reason(kMapper, kStart), "is not started with the group");
  life.life(kStereo).heard(kStart, true, "");
  EXPECT_EQ(start_due(life, kStart), "camera ");
}

TEST(GroupLife, WishesAreForOneOrAll) {
  GroupLife life(group(), {});
  start_due(life, kStart);
  ASSERT_TRUE(life.wish(GroupLife::Wish::kStop, "stereo", kStart));
  EXPECT_EQ(life.next(kStereo, kStart), Action::kInterrupt);
  EXPECT_EQ(life.next(kMapper, kStart), Action::kNone);
  ASSERT_TRUE(life.wish(GroupLife::Wish::kRestart, "", kStart));
  EXPECT_EQ(life.next(kMapper, kStart), Action::kInterrupt);
  const auto wrong = life.wish(GroupLife::Wish::kStart, "maper", kStart);
  ASSERT_FALSE(wrong);
  EXPECT_EQ(wrong.error().message, "the group has no process maper");
}

TEST(GroupLife, OnceItIsBeingEndedNobodyIsStartedAgain) {
  GroupLife life(group(), {});
  start_due(life, kStart);
  life.end(kStart);
  EXPECT_TRUE(life.ending());
  EXPECT_FALSE(life.wish(GroupLife::Wish::kStart, "stereo", kStart));
  EXPECT_EQ(life.next(kStereo, kStart), Action::kInterrupt);
  life.life(kStereo).ended(kStart, 0);
  life.life(kMapper).ended(kStart, -9);
  EXPECT_TRUE(life.nothing_runs());
  EXPECT_EQ(start_due(life, kStart + 100'000'000), "");
}

TEST(GroupLife, GoesOnWithWhatItsFormerSupervisorKnew) {
  GroupMemory memory;
  memory.processes["stereo"].life.starts = 3;
  memory.processes["mapper"].life.wanted = false;
  memory.processes["gone"].life.starts = 7;
  GroupLife life(group(), memory);
  EXPECT_EQ(life.life(kStereo).restarts(), 2);
  EXPECT_FALSE(life.life(kMapper).wanted());
  EXPECT_TRUE(life.life(kCamera).wanted());
}

}  // namespace
}  // namespace cairn
