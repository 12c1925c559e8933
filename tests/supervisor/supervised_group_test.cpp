// SPDX-License-Identifier: Apache-2.0
// Real processes under a real supervisor: deaths, hangs, crash loops, and the supervisor's own
// death. Figures are printed; the bounds are those of the house's hazard table.
#include "supervisor/supervised_group.hpp"

#include <gtest/gtest.h>
#include <sys/mount.h>
#include <sys/wait.h>

#include <csignal>
#include <fstream>
#include <iostream>
#include <random>
#include <sstream>

#include "network_namespace.hpp"
#include "procs/supervisor/group_memory.hpp"

namespace cairn::testing {
namespace {

using Names = std::vector<std::string>;

class Supervised : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!enter_network_namespace() || !add_multicast_route()) GTEST_SKIP() << kNoNamespace;
  }
  /// Sends the signal to a process that runs; its pid.
  pid_t strike(SupervisedGroup& group, const std::string& name, int signal) {
    const pid_t pid = group.process(name).pid;
    EXPECT_GT(pid, 1) << name << " does not run";
    if (pid > 1) ::kill(pid, signal);
    return pid;
  }
  /// From now until a new run of the process is up.
  double time_to_run_again_s(SupervisedGroup& group, const std::string& name, pid_t old_pid) {
    const HostTime begin_us = group.now_us();
    EXPECT_TRUE(group.wait_until([&] {
      return group.runs(name) && group.process(name).pid != old_pid;
    })) << name;
    return to_seconds(group.now_us() - begin_us);
  }
};

TEST_F(Supervised, HSup3EachProcessThatIsKilledRunsAgainWithinSeconds) {
  const Names names{"camera",  "stereo", "odometry", "localizer", "mapper",
                    "planner", "guard",  "motor",    "spare-1",   "spare-2"};
  SupervisedGroup group(names);
  ASSERT_TRUE(group.up());
  std::mt19937 random(1);
  std::vector<double> times_s;
  for (int round = 0; round < 4; ++round) {
    Names order = names;
    std::shuffle(order.begin(), order.end(), random);
    for (const std::string& name : order) {
      const pid_t pid = strike(group, name, SIGKILL);
      times_s.push_back(time_to_run_again_s(group, name, pid));
    }
  }
  std::cout << "killed to running: " << spread_text(times_s) << "\n";
  EXPECT_LE(percentile(times_s, 0.5), 2);
  EXPECT_LE(percentile(times_s, 1), 5);
  for (const std::string& name : names) EXPECT_EQ(group.process(name).restarts, 4) << name;
  EXPECT_EQ(group.pids_in_proc().size(), names.size() + 1);
}

TEST_F(Supervised, HSup4OneThatHangsIsFlaggedWithin2SecondsAndRunsAgainWithin4) {
  const Names names{"camera", "stereo", "odometry", "mapper", "planner", "guard"};
  SupervisedGroup group(names);
  ASSERT_TRUE(group.up());
  std::vector<double> flagged_s;
  std::vector<double> again_s;
  // Heartbeats come once a second: the hang begins at different times after one.
  std::int64_t phase_us = 0;
  for (const std::string& name : names) {
    const HostTime strike_us = group.now_us() + (phase_us += 160'000);
    ASSERT_TRUE(group.wait_until([&] { return group.now_us() >= strike_us; }));
    const HostTime begin_us = group.now_us();
    const pid_t pid = strike(group, name, SIGSTOP);
    ASSERT_TRUE(group.wait_until(
        [&] { return group.process(name).actual == process_state_t::ACTUAL_HUNG; }));
    flagged_s.push_back(to_seconds(group.now_us() - begin_us));
    time_to_run_again_s(group, name, pid);
    again_s.push_back(to_seconds(group.now_us() - begin_us));
  }
  std::cout << "stopped to flagged: " << spread_text(flagged_s)
            << "; to running again: " << spread_text(again_s) << "\n";
  EXPECT_LE(percentile(flagged_s, 1), 2.1) << "2 s, and what it takes to hear of it";
  EXPECT_LE(percentile(again_s, 1), 4);
  for (const std::string& name : names) EXPECT_EQ(group.process(name).restarts, 1) << name;
}

TEST_F(Supervised, HSup5OneThatExitsAtOnceIsGivenUpAndTheOthersRunOn) {
  SupervisedGroup group({"stereo", "mapper"});
  group.config().processes[1].settings = {"exit_at_once=3"};
  group.start();
  ASSERT_TRUE(group.wait_until(
      [&] { return group.process("mapper").actual == process_state_t::ACTUAL_FAILED; }));
  EXPECT_EQ(group.process("mapper").restarts, 4);
  EXPECT_EQ(group.process("mapper").exit_code, 3);
  EXPECT_EQ(group.process("mapper").reason,
            "given up after 5 quick deaths; the last: ended with code 3");
  ASSERT_TRUE(group.wait_until([&] { return group.runs("stereo"); }));
  EXPECT_EQ(group.process("stereo").restarts, 0);
  EXPECT_FALSE(group.group().ready());
  EXPECT_EQ(group.group().lacking(),
            Names{"mapper: failed: given up after 5 quick deaths; the last: ended with code 3"});
  group.group().tell(group_command_t::ACTION_START, "mapper");
  EXPECT_TRUE(group.wait_until([&] { return group.process("mapper").restarts > 4; }))
      << "by hand it gets another chance";
}

TEST_F(Supervised, HSup6ASupervisorThatIsKilledLeavesItsProcessesAndTheNextTakesThemUp) {
  SupervisedGroup group({"stereo", "mapper", "motor"});
  ASSERT_TRUE(group.up());
  const pid_t first = strike(group, "mapper", SIGKILL);
  time_to_run_again_s(group, "mapper", first);
  const pid_t stereo = group.process("stereo").pid;
  const pid_t mapper = group.process("mapper").pid;
  const pid_t motor = group.process("motor").pid;
  group.let_supervisor_die();
  ASSERT_TRUE(group.wait_until([&] { return group.group().state() == nullptr; }))
      << "3 s of silence";
  EXPECT_EQ(group.pids_in_proc(), (std::multiset<pid_t>{stereo, mapper, motor}));
  EXPECT_EQ(use_of(group.run()), RunUse::kUnsupervised);
  ASSERT_GT(motor, 1);
  ::kill(motor, SIGKILL);  // nobody is there to see it
  group.keep_again();
  ASSERT_TRUE(group.wait_until([&] { return group.group().ready(); }));
  EXPECT_EQ(group.process("stereo").pid, stereo);
  EXPECT_EQ(group.process("mapper").pid, mapper);
  EXPECT_EQ(group.process("stereo").restarts, 0);
  EXPECT_EQ(group.process("mapper").restarts, 1) << "counted on";
  EXPECT_EQ(group.process("motor").restarts, 1);
  EXPECT_NE(group.process("motor").pid, motor);
  EXPECT_EQ(group.pids_in_proc().size(), 4U);
  strike(group, "mapper", SIGKILL);
  time_to_run_again_s(group, "mapper", mapper);
  EXPECT_EQ(group.process("mapper").restarts, 2);
  strike(group, "stereo", SIGSTOP);
  time_to_run_again_s(group, "stereo", stereo);
  EXPECT_TRUE(group.down());
  EXPECT_TRUE(group.pids_in_proc().empty()) << "those that were taken up end with the rest";
}

TEST_F(Supervised, HSup7ASupervisorIsStartedAgainAndKilledInMidRestartLeavesNothingTwice) {
  const Names names{"stereo", "mapper", "motor"};
  SupervisedGroup group(names);
  ASSERT_TRUE(group.up());
  std::mt19937 random(7);
  std::vector<double> times_s;
  for (int trial = 0; trial < 8; ++trial) {
    // Its deaths are not to be quick ones.
    const HostTime rested_us = group.now_us() + 3'200'000;
    ASSERT_TRUE(group.wait_until([&] { return group.now_us() > rested_us; }));
    for (const std::string& name : names) strike(group, name, SIGKILL);
    // Anywhere from before it notices to after it has started them again.
    const HostTime strike_us = group.now_us() + random() % 450'000;
    ASSERT_TRUE(group.wait_until([&] { return group.now_us() >= strike_us; }));
    const int before = group.supervisor()->restarts();
    const HostTime begin_us = group.now_us();
    group.kill_supervisor();
    ASSERT_TRUE(group.wait_until([&] { return group.supervisor()->restarts() > before; }));
    ASSERT_TRUE(group.wait_until([&] {
      return group.group().ready() && group.group().state()->pid == group.supervisor()->pid();
    }));
    times_s.push_back(to_seconds(group.now_us() - begin_us));
    for (const std::string& name : names) {
      EXPECT_EQ(group.pids_in_proc(name), std::multiset<pid_t>{group.process(name).pid}) << name;
    }
  }
  std::cout << "all killed, supervisor too, to ready: " << spread_text(times_s) << "\n";
  EXPECT_TRUE(group.supervisor_error()) << group.supervisor_error().error().message;
  EXPECT_EQ(group.supervisor()->restarts(), 8);
  EXPECT_LE(percentile(times_s, 1), 5);
}

TEST_F(Supervised, AnEndLeavesNoProcessAndNoLock) {
  SupervisedGroup group({"stereo", "mapper"});
  ASSERT_TRUE(group.up());
  EXPECT_EQ(use_of(group.run()), RunUse::kSupervised);
  EXPECT_TRUE(group.down());
  EXPECT_TRUE(group.supervisor_error());
  EXPECT_TRUE(group.pids_in_proc().empty());
  EXPECT_EQ(use_of(group.run()), RunUse::kNone);
  EXPECT_TRUE(StateFolder::open(group.run() / "state" / "mapper"));
}

TEST_F(Supervised, ASignalToItsSupervisorEndsAGroupToo) {
  SupervisedGroup group({"stereo", "mapper"});
  ASSERT_TRUE(group.up());
  group.supervisor()->end();
  ASSERT_TRUE(group.wait_until([&] { return group.supervisor()->ended(); }));
  EXPECT_TRUE(group.pids_in_proc().empty());
}

TEST_F(Supervised, OneThatDoesNotListenIsKilledWithAllThatItStarted) {
  SupervisedGroup group({"stereo", "deaf"});
  const auto script = group.run().parent_path() / "deaf.sh";
  std::ofstream(script)
      << "#!/bin/sh\ntrap '' INT TERM\nsleep 1000 &\necho $!\nwhile :; do wait; done\n";
  std::filesystem::permissions(script, std::filesystem::perms(0755));
  group.config().processes[1].program = script;
  group.config().processes[1].stop_grace_s = 1;
  group.start();
  ASSERT_TRUE(group.wait_until([&] { return group.process("deaf").pid != 0; }));
  pid_t started = 0;
  ASSERT_TRUE(group.wait_until([&] {
    std::istringstream(group.log_of("deaf")) >> started;
    return identify(started).has_value();
  }));
  const HostTime begin_us = group.now_us();
  group.group().tell(group_command_t::ACTION_STOP, "deaf");
  ASSERT_TRUE(group.wait_until(
      [&] { return group.process("deaf").pid == 0 && !group.process("deaf").wanted; }));
  EXPECT_NEAR(to_seconds(group.now_us() - begin_us), 1, 0.5);
  EXPECT_EQ(group.process("deaf").reason, "stopped by hand; it had to be killed");
  EXPECT_TRUE(group.wait_until([&] { return !identify(started); }, 5))
      << "nobody of its session is left";
}

TEST_F(Supervised, StopStartAndRestartDoWhatTheySay) {
  SupervisedGroup group({"stereo", "mapper"});
  ASSERT_TRUE(group.up());
  const pid_t mapper = group.process("mapper").pid;
  group.group().tell(group_command_t::ACTION_STOP, "mapper");
  ASSERT_TRUE(group.wait_until([&] { return group.process("mapper").pid == 0; }));
  EXPECT_FALSE(group.process("mapper").wanted);
  EXPECT_EQ(group.process("mapper").actual, process_state_t::ACTUAL_STOPPED);
  EXPECT_TRUE(group.group().ready()) << "what is not wanted is not missed";
  group.group().tell(group_command_t::ACTION_START, "mapper");
  time_to_run_again_s(group, "mapper", mapper);
  const pid_t again = group.process("mapper").pid;
  group.group().tell(group_command_t::ACTION_RESTART, "mapper");
  EXPECT_LE(time_to_run_again_s(group, "mapper", again), 5);
  EXPECT_EQ(group.process("mapper").restarts, 2);
}

TEST_F(Supervised, WhatACrashPrintsIsOnDiskAndOnTheBusOnce) {
  SupervisedGroup group({"stereo", "mapper"});
  group.config().processes[1].settings = {"print=the last words", "crash=true"};
  std::vector<log_line_t> lines;
  group.node().on<bus::channels::LogLine>([&](const log_line_t& line) {
    if (line.process == "mapper") lines.push_back(line);
  });
  group.start();
  ASSERT_TRUE(group.wait_until(
      [&] { return group.process("mapper").actual == process_state_t::ACTUAL_FAILED; }));
  ASSERT_TRUE(group.wait_until([&] { return lines.size() >= 5; }));
  for (const log_line_t& line : lines) EXPECT_EQ(line.text, "the last words");
  EXPECT_EQ(lines.size(), 5U) << "once for each of five crashes";
  EXPECT_NE(group.log_of("mapper").find("the last words\nsupervisor: mapper: killed by SIGABRT; "
                                        "starts again in 0.3 s\n"),
            std::string::npos)
      << group.log_of("mapper");
}

TEST_F(Supervised, AFullDiskStopsNothing) {
  SupervisedGroup group({"stereo", "mapper"});
  std::filesystem::create_directories(group.run());
  if (::unshare(CLONE_NEWNS) != 0 ||
      ::mount("none", "/", nullptr, MS_REC | MS_PRIVATE, nullptr) != 0 ||
      ::mount("tmpfs", group.run().c_str(), "tmpfs", 0, "size=1m") != 0) {
    GTEST_SKIP() << "cannot make a small disk here";
  }
  ASSERT_TRUE(group.up());
  std::ofstream filler(group.run() / "filler");
  const std::string block(4'096, 'x');
  while (filler.write(block.data(), 4'096) && filler.flush()) {
  }
  ASSERT_EQ(std::filesystem::space(group.run()).available, 0U);
  for (const char* name : {"stereo", "mapper", "stereo"}) {
    const pid_t pid = strike(group, name, SIGKILL);
    EXPECT_LE(time_to_run_again_s(group, name, pid), 5) << name;
  }
  group.kill_supervisor();
  const int before = group.supervisor()->restarts();
  ASSERT_TRUE(group.wait_until([&] { return group.supervisor()->restarts() > before; }));
  ASSERT_TRUE(group.wait_until([&] {
    return group.group().ready() && group.group().state()->pid == group.supervisor()->pid();
  }));
  EXPECT_EQ(group.process("stereo").restarts, 2) << "what it knew was kept";
  EXPECT_TRUE(group.down());
  EXPECT_TRUE(group.pids_in_proc().empty());
}

TEST_F(Supervised, ARunHasOneSupervisorAndABusOneGroup) {
  SupervisedGroup group({"stereo"});
  ASSERT_TRUE(group.up());
  auto second = cli::KeptSupervisor::start(group.run(), group.now_us());
  ASSERT_TRUE(second);
  Result<void> looked;
  ASSERT_TRUE(group.wait_until([&] {
    looked = second->look_after(group.now_us());
    return !looked;
  }));
  EXPECT_NE(looked.error().message.find("is the state folder of a process that is running"),
            std::string::npos)
      << looked.error().message;
  SupervisedGroup other({"stereo"});
  other.start();
  ASSERT_TRUE(other.wait_until([&] { return !other.supervisor_error(); }));
  EXPECT_NE(other.supervisor_error().error().message.find("another group's "), std::string::npos);
  EXPECT_NE(other.supervisor_error().error().message.find("--lcm-url"), std::string::npos);
  EXPECT_TRUE(other.pids_in_proc().empty());
  EXPECT_TRUE(group.wait_until([&] { return group.group().ready(); }));
  EXPECT_EQ(group.process("stereo").restarts, 0);
}

TEST_F(Supervised, ASupervisorThatWasNotScheduledBlamesNobody) {
  SupervisedGroup group({"stereo", "mapper"});
  ASSERT_TRUE(group.up());
  const pid_t supervisor = group.supervisor()->pid();
  ::kill(supervisor, SIGSTOP);
  ASSERT_TRUE(group.wait_until([&] { return group.group().state() == nullptr; }));
  const HostTime later_us = group.now_us() + 2'000'000;
  ASSERT_TRUE(group.wait_until([&] { return group.now_us() > later_us; }));
  ::kill(supervisor, SIGCONT);
  ASSERT_TRUE(group.wait_until([&] { return group.group().ready(); }));
  const HostTime end_us = group.now_us() + 3'000'000;
  ASSERT_TRUE(group.wait_until([&] { return group.now_us() > end_us; }));
  EXPECT_EQ(group.process("stereo").restarts, 0);
  EXPECT_EQ(group.process("mapper").restarts, 0);
}

}  // namespace
}  // namespace cairn::testing
