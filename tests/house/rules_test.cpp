// SPDX-License-Identifier: Apache-2.0
#include "house/rules.hpp"

#include <gtest/gtest.h>

namespace cairn::house {
namespace {

const SourceTree& project() {
  static const SourceTree tree = read_source_tree(CAIRN_SOURCE_DIR);
  return tree;
}

TEST(HouseRules, AMainOnlyWires) { EXPECT_EQ(joined(long_mains(project())), ""); }

TEST(HouseRules, NoBuildIsBoundToItsMachine) {
  EXPECT_EQ(joined(machine_bound_flags(project())), "");
}

TEST(HouseRules, ScienceReadsNoClock) { EXPECT_EQ(joined(clock_reads_in_science(project())), ""); }

TEST(HouseRules, NoTestSleeps) { EXPECT_EQ(joined(sleeping_tests(project())), ""); }

TEST(HouseRules, NothingIsLeftForLater) { EXPECT_EQ(joined(left_for_later(project())), ""); }

TEST(HouseRules, EveryFileNamesItsLicence) { EXPECT_EQ(joined(without_licence(project())), ""); }

TEST(HouseRules, AMainOf40LinesIsShortAndOneOf41IsLong) {
  std::string text;
  for (int line = 0; line < 40; ++line) text += "x;\n";
  EXPECT_TRUE(long_mains({{"procs/a/main.cpp", text}}).empty());
  EXPECT_EQ(long_mains({{"procs/a/main.cpp", text + "x;\n"}}).size(), 1u);
  EXPECT_TRUE(long_mains({{"procs/a/a_node.cpp", text + "x;\n"}}).empty());
}

TEST(HouseRules, AMachineBoundFlagIsFoundInEveryKindOfBuildFile) {
  EXPECT_EQ(machine_bound_flags({{"CMakeLists.txt", "add_compile_options(-O3 -march=native)\n"}}),
            (Findings{"CMakeLists.txt:1: march=native: breaks on the next machine; choose at run "
                      "time"}));
  EXPECT_EQ(machine_bound_flags({{"CMakePresets.json", "\"-march=native\""}}).size(), 1u);
  EXPECT_TRUE(machine_bound_flags({{"CMakeLists.txt", "# no -march=native here\n"}}).empty());
}

TEST(HouseRules, AClockReadIsFoundOnlyInTheScience) {
  const std::string text = "auto t = std::chrono::steady_clock::now();\n";
  EXPECT_EQ(clock_reads_in_science({{"lib/stereo/a.cpp", text}}).size(), 1u);
  EXPECT_TRUE(clock_reads_in_science({{"lib/bus/a.cpp", text}}).empty());
  EXPECT_TRUE(clock_reads_in_science({{"lib/stereo/a.cpp", "// " + text}}).empty());
}

TEST(HouseRules, ASleepIsFoundOnlyInTestCode) {
  EXPECT_EQ(sleeping_tests({{"tests/bus/a_test.cpp", "std::this_thread::sleep_for(1s);"}}).size(),
            1u);
  EXPECT_TRUE(sleeping_tests({{"tests/bus/a_test.cpp", "f(\"usleep\"); // usleep(1)"}}).empty());
  EXPECT_TRUE(sleeping_tests({{"lib/bus/a.cpp", "usleep(1);"}}).empty());
}

TEST(HouseRules, WhatIsLeftForLaterIsFoundInComments) {
  EXPECT_EQ(left_for_later({{"lib/a/a.cpp", "// TODO: the rest\n"}}).size(), 1u);
  EXPECT_TRUE(left_for_later({{"lib/a/a.cpp", "mkstemp(\"aXXXXXX\");\n"}}).empty());
}

TEST(HouseRules, ALicenceBelowTheFirstLineIsNone) {
  const std::string licence = "// SPDX-License-Identifier: Apache-2.0\n";
  EXPECT_TRUE(without_licence({{"lib/a/a.hpp", licence + "#pragma once\n"}}).empty());
  EXPECT_EQ(without_licence({{"lib/a/a.hpp", "#pragma once\n" + licence}}).size(), 1u);
}

}  // namespace
}  // namespace cairn::house
