// SPDX-License-Identifier: Apache-2.0
#include "core/start_program.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <fstream>
#include <sstream>

#include "core/child_process.hpp"
#include "temporary_folder.hpp"

namespace cairn {
namespace {

int wait_for(pid_t pid) {
  int status = 0;
  EXPECT_EQ(::waitpid(pid, &status, 0), pid);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
}

// Runs a line of shell under `program`'s other settings; what it printed.
std::string output_of(Program program, const std::string& line) {
  const testing::TemporaryFolder folder;
  program.command = {"/bin/sh", "-c", line};
  program.output = folder.path() / "output";
  const auto pid = start_program(program);
  EXPECT_TRUE(pid) << pid.error().message;
  EXPECT_EQ(pid ? wait_for(*pid) : -1, 0);
  std::ifstream file(program.output);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

TEST(StartProgram, GetsItsEnvironmentBesideOursAndWinsOverIt) {
  ::setenv("CAIRN_TEST_OURS", "ours", 1);
  ::setenv("CAIRN_TEST_BOTH", "ours", 1);
  Program program;
  program.environment = {"CAIRN_TEST_BOTH=its", "CAIRN_TEST_ITS=its"};
  EXPECT_EQ(output_of(program, "echo $CAIRN_TEST_OURS $CAIRN_TEST_BOTH $CAIRN_TEST_ITS"),
            "ours its its\n");
}

TEST(StartProgram, GetsNoFileOfOursAndNoSignalThatIsBlocked) {
  const int leaked = ::open("/dev/null", O_RDONLY);
  ASSERT_GT(leaked, 2);
  sigset_t blocked;
  sigemptyset(&blocked);
  sigaddset(&blocked, SIGTERM);
  ::pthread_sigmask(SIG_BLOCK, &blocked, nullptr);
  const auto old = std::signal(SIGPIPE, SIG_IGN);
  // The shell lives on behind `ls`, and holds nothing for it: a pipe would show in the list.
  EXPECT_EQ(output_of({}, "ls /proc/$$/fd; true"), "0\n1\n2\n");
  EXPECT_EQ(output_of({}, "grep -E 'SigBlk|SigIgn' /proc/$$/status | cut -f2"),
            "0000000000000000\n0000000000000000\n");
  ::pthread_sigmask(SIG_UNBLOCK, &blocked, nullptr);
  std::signal(SIGPIPE, old);
  ::close(leaked);
}

TEST(StartProgram, WhatCannotBeNotedNeverRuns) {
  const testing::TemporaryFolder folder;
  const auto mark = folder.path() / "ran";
  Program program;
  program.command = {"/usr/bin/touch", mark};
  pid_t noted = 0;
  program.note = [&](pid_t pid) -> Result<void> {
    noted = pid;
    return fail("no room left");
  };
  const auto pid = start_program(program);
  ASSERT_FALSE(pid);
  EXPECT_EQ(pid.error().message, "no room left");
  EXPECT_GT(noted, 0);
  EXPECT_NE(::kill(noted, 0), 0) << "it is gone";
  EXPECT_FALSE(std::filesystem::exists(mark));
}

TEST(StartProgram, AStarterThatIsKilledWhileItNotesLeavesNothingThatRuns) {
  const testing::TemporaryFolder folder;
  const auto mark = folder.path() / "ran";
  int said[2];
  ASSERT_EQ(::pipe(said), 0);
  const pid_t starter = ::fork();
  if (starter == 0) {
    Program program;
    program.command = {"/usr/bin/touch", mark};
    program.outlives_starter = true;
    program.note = [&](pid_t pid) -> Result<void> {
      if (::write(said[1], &pid, sizeof(pid)) < 0) ::_exit(1);
      ::kill(::getpid(), SIGKILL);
      return {};
    };
    (void)start_program(program);
    ::_exit(1);
  }
  ::close(said[1]);
  pid_t pid = 0;
  ASSERT_EQ(::read(said[0], &pid, sizeof(pid)), static_cast<ssize_t>(sizeof(pid)));
  EXPECT_EQ(wait_for(starter), -SIGKILL);
  // The pipe's end comes when the last that held it has gone.
  char nothing = 0;
  EXPECT_EQ(::read(said[0], &nothing, 1), 0);
  ::close(said[0]);
  EXPECT_FALSE(std::filesystem::exists(mark));
}

TEST(StartProgram, OneThatOutlivesUsHasASessionOfItsOwn) {
  Program program;
  program.outlives_starter = true;
  EXPECT_EQ(output_of(program, "test $(ps -o sid= -p $$) = $$ && echo own"), "own\n");
}

TEST(StartProgram, AMissingProgramIsNamed) {
  Program program;
  program.command = {"/nowhere/cairn-nobody"};
  const auto pid = start_program(program);
  ASSERT_FALSE(pid);
  EXPECT_EQ(pid.error().message, "/nowhere/cairn-nobody: cannot be run: No such file or directory");
}

TEST(ChildProcess, IsKilledWithItsOwner) {
  pid_t pid = 0;
  {
    auto child = ChildProcess::start({"/bin/sleep", "1000"}, "");
    ASSERT_TRUE(child) << child.error().message;
    pid = child->pid();
    EXPECT_FALSE(child->exit_code());
  }
  EXPECT_NE(::kill(pid, 0), 0);
}

}  // namespace
}  // namespace cairn
