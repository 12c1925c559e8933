// SPDX-License-Identifier: Apache-2.0
#include "procs/supervisor/group_config.hpp"

#include <gtest/gtest.h>

#include <fstream>

#include "bus/process.hpp"
#include "core/start_program.hpp"
#include "temporary_folder.hpp"

namespace cairn {
namespace {

namespace fs = std::filesystem;

class GroupFile : public ::testing::Test {
 protected:
  fs::path write(const std::string& text) {
    std::ofstream(folder_.path() / "group.yaml") << text;
    return folder_.path() / "group.yaml";
  }
  std::string error_of(const std::string& text) {
    const auto group = load_group(write(text));
    return group ? "" : group.error().message;
  }
  std::string at_line(int line) {
    return (folder_.path() / "group.yaml").string() + ":" + std::to_string(line) + ": ";
  }
  testing::TemporaryFolder folder_;
};

TEST_F(GroupFile, IsLoadedWithPathsThatDoNotDependOnWhereOneStands) {
  std::ofstream(folder_.path() / "robot.yaml") << "";
  std::ofstream(folder_.path() / "mine.sh") << "";
  const auto group =
      load_group(write("robot: robot.yaml\n"
                       "processes:\n"
                       "  - name: stereo\n"
                       "    settings: [method=block, \"a=${HERE}/x\"]\n"
                       "  - name: mine\n"
                       "    program: ./mine.sh\n"
                       "    settings: [\"device=${RUN}/wheels\", \"two=${RUN}${RUN}\"]\n"
                       "    after: [stereo]\n"
                       "    restart: on_failure\n"
                       "    at_start: false\n"
                       "    stop_grace_s: 2\n"));
  ASSERT_TRUE(group) << group.error().message;
  const std::string here = fs::weakly_canonical(folder_.path()).string();
  EXPECT_EQ(group->group, here + "/group.yaml");
  EXPECT_EQ(group->robot, here + "/robot.yaml");
  using Words = std::vector<std::string>;
  EXPECT_EQ(command_of(*group, group->processes[0], "/run/1"),
            (Words{(program_folder() / "cairn-stereo").string(), "--state", "/run/1/state/stereo",
                   "--config", here + "/robot.yaml", "--set", "method=block", "--set",
                   "a=" + here + "/x"}));
  EXPECT_EQ(
      command_of(*group, group->processes[1], "/run/1"),
      (Words{here + "/mine.sh", "--state", "/run/1/state/mine", "--config", here + "/robot.yaml",
             "--set", "device=/run/1/wheels", "--set", "two=/run/1/run/1"}));
}

TEST_F(GroupFile, ComesBackFromItsPrintedForm) {
  const auto group =
      load_group(write("lcm_url: udpm://239.255.76.67:7700?ttl=0\n"
                       "processes:\n"
                       "  - {name: stereo, settings: [\"a: b=\\\"c\\\"\"]}\n"
                       "  - {name: mapper, after: [stereo], restart: never, at_start: false}\n"));
  ASSERT_TRUE(group) << group.error().message;
  const auto again = load_group(write(print_group(*group)));
  ASSERT_TRUE(again) << again.error().message;
  EXPECT_EQ(print_group(*again), print_group(*group));
  EXPECT_EQ(again->processes[0].settings, group->processes[0].settings);
  EXPECT_EQ(again->processes[1].after, std::vector<std::string>{"stereo"});
}

TEST_F(GroupFile, AMisspeltKeyIsNamedWithItsLine) {
  EXPECT_EQ(error_of("processes:\n  - name: stereo\n    restat: always\n"),
            at_line(3) + "processes[0].restat: unknown key (did you mean 'restart'?)");
}

TEST_F(GroupFile, AnUnknownProcessIsNamedWithItsLine) {
  const std::string error = error_of("processes:\n  - name: stereo\n  - name: maper\n");
  EXPECT_TRUE(error.starts_with(at_line(3) + "processes[1].name: 'maper' is none of the project's "
                                             "processes (allowed: camera, simulator,"))
      << error;
}

TEST_F(GroupFile, AMissingRobotFileIsNamedWithItsLine) {
  EXPECT_EQ(error_of("processes:\n  - name: stereo\nrobot: nobody.yaml\n"),
            at_line(3) + "robot: " + fs::weakly_canonical(folder_.path() / "nobody.yaml").string() +
                ": no such file");
}

TEST_F(GroupFile, AMissingProgramIsNamed) {
  EXPECT_EQ(error_of("processes:\n  - {name: mine, program: mine.py}\n"),
            at_line(2) + "processes: " + fs::weakly_canonical(folder_.path() / "mine.py").string() +
                ": no such file");
}

TEST_F(GroupFile, OneWaitsOnlyForThoseThatStandAboveIt) {
  EXPECT_EQ(error_of("processes:\n  - {name: camera, after: [stereo]}\n  - name: stereo\n"),
            at_line(2) + "processes: camera.after: stereo does not stand above it");
}

TEST_F(GroupFile, WhatMakesNoSenseIsRefused) {
  EXPECT_EQ(error_of("processes: []\n"), at_line(1) + "processes: names no process");
  EXPECT_NE(error_of("processes:\n  - name: stereo\n  - name: stereo\n").find("stands here twice"),
            std::string::npos);
  EXPECT_NE(error_of("processes:\n  - name: ../stereo\n").find("is no name"), std::string::npos);
  EXPECT_NE(error_of("processes:\n  - name: supervisor\n").find("is no name"), std::string::npos);
  EXPECT_NE(error_of("processes:\n  - {name: stereo, settings: [method]}\n")
                .find("is not of the form KEY=VALUE"),
            std::string::npos);
  EXPECT_NE(error_of("processes:\n  - {name: stereo, restart: often}\n").find("always, on_failure"),
            std::string::npos);
}

TEST_F(GroupFile, AMissingFileIsNamed) {
  const auto group = load_group("nowhere/group.yaml");
  ASSERT_FALSE(group);
  EXPECT_EQ(group.error().message, "nowhere/group.yaml: no such file");
}

// Each of the groups that ship, with the robot file that it names.
TEST(ShippedGroups, AreAllGood) {
  int files = 0;
  for (const auto& entry : fs::directory_iterator(fs::path(CAIRN_SOURCE_DIR) / "config/groups")) {
    if (entry.path().extension() != ".yaml") continue;
    ++files;
    const auto group = load_group(entry.path());
    ASSERT_TRUE(group) << group.error().message;
    EXPECT_TRUE(fs::exists(group->robot)) << entry.path();
  }
  EXPECT_EQ(files, 3);
}

}  // namespace
}  // namespace cairn
