// SPDX-License-Identifier: Apache-2.0
#include "procs/supervisor/running_program.hpp"

#include <gtest/gtest.h>
#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <fstream>
#include <sstream>

#include "temporary_folder.hpp"

namespace cairn {
namespace {

RunningProgram start(const std::vector<std::string>& command,
                     const std::filesystem::path& output = {}) {
  Program program;
  program.command = command;
  program.output = output;
  return RunningProgram::start(program, [](ProgramId) { return Result<void>{}; }).value();
}

RunningProgram::End wait_for_end(RunningProgram& program) {
  auto end = program.end();
  while (!end) {
    ::poll(nullptr, 0, 2);
    end = program.end();
  }
  return *end;
}

template <class Condition>
bool holds_within_10_s(Condition condition) {
  for (int i = 0; i < 5'000 && !condition(); ++i) ::poll(nullptr, 0, 2);
  return condition();
}

TEST(RunningProgram, SaysHowItEnded) {
  RunningProgram ends = start({"/bin/sh", "-c", "exit 7"});
  EXPECT_EQ(wait_for_end(ends).exit_code, 7);
  RunningProgram sleeps = start({"/bin/sleep", "1000"});
  EXPECT_EQ(identify(sleeps.id().pid), sleeps.id());
  EXPECT_FALSE(sleeps.end());
  sleeps.signal(SIGTERM);
  EXPECT_EQ(wait_for_end(sleeps).exit_code, -SIGTERM);
  EXPECT_FALSE(identify(sleeps.id().pid));
}

TEST(RunningProgram, RunsOnWhereItsHandleGoesAwayAndIsAdoptedByItsId) {
  ProgramId id;
  { id = start({"/bin/sleep", "1000"}).id(); }
  auto adopted = RunningProgram::adopt(id);
  ASSERT_TRUE(adopted);
  EXPECT_FALSE(adopted->end());
  EXPECT_TRUE(adopted->owns(id.pid));
  EXPECT_FALSE(adopted->owns(::getpid()));
  adopted->signal(SIGKILL);
  EXPECT_FALSE(wait_for_end(*adopted).exit_code) << "nobody but its starter can know";
  EXPECT_FALSE(RunningProgram::adopt(id)) << "a zombie does not run";
  ::waitpid(id.pid, nullptr, 0);
}

TEST(RunningProgram, APidThatSomebodyElseHasNowIsNotAdopted) {
  RunningProgram program = start({"/bin/sleep", "1000"});
  ProgramId other = program.id();
  other.start_ticks -= 1;
  EXPECT_FALSE(RunningProgram::adopt(other));
  EXPECT_FALSE(RunningProgram::adopt({0, 0}));
  EXPECT_FALSE(RunningProgram::adopt({-1, 0}));
  program.signal(SIGKILL);
  wait_for_end(program);
}

TEST(RunningProgram, WhatItStartedEndsWithIt) {
  const testing::TemporaryFolder folder;
  RunningProgram shell =
      start({"/bin/sh", "-c", "sleep 1000 & echo $!; wait"}, folder.path() / "out");
  pid_t grandchild = 0;
  ASSERT_TRUE(holds_within_10_s([&] {
    std::ifstream(folder.path() / "out") >> grandchild;
    return grandchild != 0 && stat_of(grandchild).has_value();
  }));
  EXPECT_TRUE(shell.owns(grandchild));
  ::kill(shell.id().pid, SIGKILL);
  EXPECT_EQ(wait_for_end(shell).exit_code, -SIGKILL);
  EXPECT_TRUE(holds_within_10_s([&] { return !stat_of(grandchild); }));
}

TEST(RunningProgram, WhatCannotBeNotedNeverRuns) {
  Program program;
  program.command = {"/bin/sleep", "1000"};
  ProgramId noted;
  const auto started = RunningProgram::start(program, [&](ProgramId id) -> Result<void> {
    noted = id;
    return fail("no room left");
  });
  ASSERT_FALSE(started);
  EXPECT_EQ(started.error().message, "no room left");
  EXPECT_FALSE(identify(noted.pid));
}

// A program may call itself what it wants.
TEST(RunningProgram, IsIdentifiedWhateverItsName) {
  const testing::TemporaryFolder folder;
  const auto odd = folder.path() / ") Z 1 2 (";
  std::filesystem::copy_file("/bin/sleep", odd);
  RunningProgram program = start({odd, "1000"});
  EXPECT_TRUE(holds_within_10_s([&] {
    std::ifstream comm("/proc/" + std::to_string(program.id().pid) + "/comm");
    std::string name;
    std::getline(comm, name);
    return name == ") Z 1 2 (";
  }));
  EXPECT_EQ(identify(program.id().pid), program.id());
  program.signal(SIGKILL);
  wait_for_end(program);
}

}  // namespace
}  // namespace cairn
