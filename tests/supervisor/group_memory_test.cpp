// SPDX-License-Identifier: Apache-2.0
#include "procs/supervisor/group_memory.hpp"

#include <gtest/gtest.h>

#include <random>

#include "temporary_folder.hpp"

namespace cairn {
namespace {

GroupMemory sample() {
  GroupMemory memory;
  memory.supervisor_starts = 3;
  memory.ending = true;
  memory.processes["mapper"] = {{true, false, 7, -11, "killed by SIGSEGV"},
                                {1234, 987'654'321'000}};
  memory.processes["stereo"] = {{false, true, 5, 1, "given up \xff\n\"x\""}, {}};
  return memory;
}

TEST(GroupMemory, ComesBackAsItWas) {
  const auto back = group_memory(to_bytes(sample(), "boot-1"), "boot-1");
  ASSERT_TRUE(back);
  EXPECT_EQ(back->supervisor_starts, 3);
  EXPECT_TRUE(back->ending);
  const auto& mapper = back->processes.at("mapper");
  EXPECT_TRUE(mapper.life.wanted);
  EXPECT_FALSE(mapper.life.failed);
  EXPECT_EQ(mapper.life.starts, 7);
  EXPECT_EQ(mapper.life.exit_code, -11);
  EXPECT_EQ(mapper.life.reason, "killed by SIGSEGV");
  EXPECT_EQ(mapper.program, (ProgramId{1234, 987'654'321'000}));
  EXPECT_TRUE(back->processes.at("stereo").life.failed);
}

TEST(GroupMemory, OfAnotherBootKnowsNoProgramThatRuns) {
  const auto back = group_memory(to_bytes(sample(), "boot-1"), "boot-2");
  ASSERT_TRUE(back);
  EXPECT_EQ(back->processes.at("mapper").program.pid, 0);
  EXPECT_EQ(back->processes.at("mapper").life.starts, 7);
}

TEST(GroupMemory, IsNothingOnceItIsForgotten) {
  const testing::TemporaryFolder folder;
  const auto state = StateFolder::open(folder.path()).value();
  EXPECT_FALSE(recall_group(state));
  ASSERT_TRUE(remember_group(state, sample()));
  ASSERT_TRUE(recall_group(state));
  EXPECT_EQ(recall_group(state)->processes.at("mapper").program.pid, 1234);
  ASSERT_TRUE(forget_group(state));
  EXPECT_FALSE(recall_group(state));
}

// A disk that becomes full must not keep a process from being started.
TEST(GroupMemory, TakesNoMoreRoomWhenItGrows) {
  const testing::TemporaryFolder folder;
  const auto state = StateFolder::open(folder.path()).value();
  const auto size = [&] {
    std::uintmax_t sum = 0;
    for (const auto& file : std::filesystem::directory_iterator(folder.path()))
      sum += file.file_size();
    return sum;
  };
  ASSERT_TRUE(remember_group(state, {}));
  const std::uintmax_t at_first = size();
  GroupMemory large = sample();
  for (int i = 0; i < 20; ++i) {
    large.processes["process-" + std::to_string(i)].life.reason = std::string(10'000, 'x');
  }
  ASSERT_TRUE(remember_group(state, large));
  ASSERT_TRUE(remember_group(state, large));
  EXPECT_EQ(size(), at_first);
}

TEST(GroupMemory, SeededCorruptionsAreNothingOrWhole) {
  const std::vector<std::uint8_t> good = to_bytes(sample(), "boot-1");
  std::mt19937 random(1);
  int survived = 0;
  for (int trial = 0; trial < 2'000; ++trial) {
    std::vector<std::uint8_t> bytes = good;
    const std::size_t damages = 1 + random() % 4;
    for (std::size_t i = 0; i < damages; ++i) {
      bytes[random() % 700] = static_cast<std::uint8_t>(random());
    }
    if (random() % 4 == 0) bytes.resize(random() % bytes.size());
    survived += group_memory(bytes, "boot-1") ? 1 : 0;
  }
  EXPECT_LT(survived, 1'900) << "most damage is seen";
}

}  // namespace
}  // namespace cairn
