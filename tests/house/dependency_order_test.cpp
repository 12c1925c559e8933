// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <iostream>

#include "house/dependencies.hpp"

namespace cairn::house {
namespace {

const SourceTree& project() {
  static const SourceTree tree = read_source_tree(CAIRN_SOURCE_DIR);
  return tree;
}

TEST(DependencyOrder, NoFolderDependsOnItself) {
  const DependencyGraph graph = dependency_graph(project());
  for (const std::string& folder : dependency_order(graph)) {
    std::cout << folder << ":";
    for (const auto& [needed, because] : graph.at(folder)) std::cout << " " << needed;
    std::cout << "\n";
  }
  EXPECT_EQ(joined(cycle_in(graph)), "");
  EXPECT_EQ(dependency_order(graph).size(), graph.size());
}

TEST(DependencyOrder, ScienceKnowsNoBus) { EXPECT_EQ(joined(forbidden_includes(project())), ""); }

TEST(DependencyOrder, EachFolderComesAfterWhatItNeeds) {
  const SourceTree tree{{"lib/a/a.hpp", "#include \"c/c.hpp\"\n"},
                        {"lib/b/b.cpp", "#include \"a/a.hpp\"\n#include \"c/c.hpp\"\n"},
                        {"lib/c/c.hpp", "#include <vector>\n"},
                        {"procs/a/node.cpp", "#include \"b/b.cpp\"\n#include \"node.hpp\"\n"},
                        {"procs/a/node.hpp", ""}};
  EXPECT_EQ(dependency_order(dependency_graph(tree)),
            (std::vector<std::string>{"lib/c", "lib/a", "lib/b", "procs/a"}));
}

TEST(DependencyOrder, ACycleIsNamedStepByStep) {
  const SourceTree tree{{"lib/a/a.hpp", "#include \"b/b.hpp\"\n"},
                        {"lib/b/b.hpp", "\n#  include \"c/c.hpp\"\n"},
                        {"lib/c/c.hpp", "#include \"b/b.hpp\"\n"}};
  const DependencyGraph graph = dependency_graph(tree);
  EXPECT_EQ(cycle_in(graph), (Findings{"lib/b/b.hpp:2: a cycle: lib/b includes lib/c",
                                       "lib/c/c.hpp:1: a cycle: lib/c includes lib/b"}));
  EXPECT_TRUE(dependency_order(graph).empty());
}

TEST(DependencyOrder, ACycleAmongProcessesIsFoundToo) {
  const SourceTree tree{{"procs/a/a.hpp", "#include \"b/b.hpp\"\n"},
                        {"procs/b/b.hpp", "#include \"a/a.hpp\"\n"}};
  EXPECT_EQ(cycle_in(dependency_graph(tree)).size(), 2u);
}

TEST(DependencyOrder, AnIncludeInACommentIsNone) {
  const SourceTree tree{{"lib/a/a.hpp", "// #include \"b/b.hpp\"\n"},
                        {"lib/b/b.hpp", "#include \"a/a.hpp\"\n"}};
  EXPECT_TRUE(cycle_in(dependency_graph(tree)).empty());
}

TEST(DependencyOrder, AFolderOfBothKindsIsToldApart) {
  const SourceTree tree{{"lib/camera/rig.hpp", ""},
                        {"procs/camera/node.hpp", "#include \"camera/rig.hpp\"\n"},
                        {"procs/cli/cli.hpp", "#include \"procs/camera/node.hpp\"\n"}};
  const DependencyGraph graph = dependency_graph(tree);
  EXPECT_TRUE(graph.at("lib/camera").empty());
  EXPECT_TRUE(graph.at("procs/camera").contains("lib/camera"));
  EXPECT_TRUE(graph.at("procs/cli").contains("procs/camera"));
}

TEST(DependencyOrder, EveryWayForScienceToKnowTheBusIsRefused) {
  const SourceTree tree{
      {"lib/bus/bus.hpp", "#include <lcm/lcm.h>\n#include \"cairn/pose_t.hpp\"\n"},
      {"lib/messages/pack.hpp", "#include <cairn/pose_t.hpp>\n"},
      {"lib/stereo/bus.hpp", "#include \"bus/bus.hpp\"\n"},
      {"lib/stereo/lcm.hpp", "#include <lcm/lcm-cpp.hpp>\n"},
      {"lib/stereo/pack.hpp", "#include \"messages/pack.hpp\"\n"},
      {"lib/stereo/pose.hpp", "#include <cairn/pose_t.hpp>\n"}};
  EXPECT_EQ(joined(forbidden_includes(tree)),
            "lib/stereo/bus.hpp:1: bus/bus.hpp: science knows no bus\n"
            "lib/stereo/lcm.hpp:1: lcm/lcm-cpp.hpp: only lib/bus includes LCM\n"
            "lib/stereo/pack.hpp:1: messages/pack.hpp: science knows no bus\n"
            "lib/stereo/pose.hpp:1: cairn/pose_t.hpp: science knows no messages\n");
}

TEST(DependencyOrder, OnlyTheBusIncludesLcm) {
  const SourceTree tree{{"lib/bus/bus.cpp", "#include <lcm/lcm.h>\n"},
                        {"lib/messages/pack.cpp", "#include <lcm/lcm_coretypes.h>\n"},
                        {"procs/mapper/node.cpp", "#include <lcm/lcm.h>\n"}};
  EXPECT_EQ(forbidden_includes(tree).size(), 2u);
}

TEST(DependencyOrder, ALibraryKnowsNoProcess) {
  const SourceTree tree{{"lib/bus/bus.cpp", "#include \"mapper/node.hpp\"\n"},
                        {"procs/mapper/node.hpp", ""}};
  EXPECT_EQ(joined(forbidden_includes(tree)),
            "lib/bus/bus.cpp:1: mapper/node.hpp: a library knows no process\n");
}

}  // namespace
}  // namespace cairn::house
