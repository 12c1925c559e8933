// SPDX-License-Identifier: Apache-2.0
// What can be wrong with a demo is said at once, before anything starts or is written.
#include <gtest/gtest.h>

#include "network_namespace.hpp"
#include "system/demo_runs.hpp"
#include "system/live_group.hpp"
#include "system/recordings_of_tests.hpp"
#include "system/small_worlds.hpp"
#include "temporary_folder.hpp"

namespace cairn::testing {
namespace {

namespace fs = std::filesystem;

class DemoBadInput : public ::testing::Test {
 protected:
  // Whether live or fast: the same words are wrong.
  void expect_refused(const std::vector<std::string>& words, int code, const std::string& why) {
    for (const bool fast : {false, true}) {
      std::vector<std::string> command{"demo", "--headless", "--out", folder_.path() / "out"};
      command.insert(command.end(), words.begin(), words.end());
      if (fast) command.emplace_back("--fast");
      const Ran ran = run_cairn(command);
      EXPECT_EQ(ran.code, code) << ran.output;
      EXPECT_NE(ran.output.find(why), std::string::npos) << ran.output;
      EXPECT_FALSE(fs::exists(folder_.path() / "out")) << "nothing was begun";
    }
  }

  TemporaryFolder folder_;
};

TEST_F(DemoBadInput, AWorldThatIsNotThereIsNamed) {
  expect_refused({"--world", "/nowhere/castle.yaml"}, 1, "/nowhere/castle.yaml");
}

TEST_F(DemoBadInput, AWrongKeyOfAWorldIsNamedWithFileAndLine) {
  const fs::path world = small_world(folder_.path(), "  - {name: ball, radius_m: 1}\n");
  expect_refused({"--world", world}, 1, world.string() + ":13:");
}

TEST_F(DemoBadInput, AWorldThatIsNoYamlIsNamedWithFileAndLine) {
  const fs::path world = folder_.path() / "broken.yaml";
  std::ofstream(world) << "start: {at_m: [0, 0]\nboxes:\n  - [\n";
  expect_refused({"--world", world}, 1, world.string() + ":");
}

TEST_F(DemoBadInput, AStartInsideOfAWallIsRefused) {
  const fs::path world = small_world(
      folder_.path(),
      "  - {name: block, centre_m: [-0.9, -0.8, 0.5], size_m: [1, 1, 1], material: wood}\n");
  expect_refused({"--world", world}, 1, world.string());
}

TEST_F(DemoBadInput, MorePeopleThanTheWorldHasAreRefused) {
  expect_refused({"--world", small_world(folder_.path()), "--people", "3"}, 1, "small.yaml");
}

TEST_F(DemoBadInput, WrongOptionsAndSettingsAreUsageErrors) {
  expect_refused({"--seed", "many"}, 2, "--seed");
  expect_refused({"--no-such-flag"}, 2, "--no-such-flag");
  expect_refused({"--set", "mapper.resoluton_m=0.1"}, 2, "did you mean 'resolution_m'");
  expect_refused({"--set", "toaster.on=1"}, 2, "toaster.on=1");
}

TEST_F(DemoBadInput, AFolderWithOtherFilesIsNotWrittenInto) {
  const fs::path out = folder_.path() / "thesis";
  fs::create_directories(out);
  std::ofstream(out / "thesis.tex") << "years of work";
  const Ran ran = run_cairn({"demo", "--fast", "--out", out});
  EXPECT_EQ(ran.code, 1);
  EXPECT_NE(ran.output.find("no run of cairn wrote"), std::string::npos) << ran.output;
  EXPECT_TRUE(fs::exists(out / "thesis.tex"));
}

TEST_F(DemoBadInput, AnotherGroupOnThePortIsNotMixedWith) {
  if (!enter_network_namespace() || !add_multicast_route()) GTEST_SKIP() << kNoNamespace;
  LiveGroup group(rendered_room());
  group.start("stereo");
  ASSERT_TRUE(group.listen_until_heard({"stereo"}));
  const Ran ran = run_cairn({"demo", "--headless", "--world", small_world(folder_.path()),
                             "--lcm-url", kStockUrl, "--out", folder_.path() / "out"});
  group.stop();
  EXPECT_EQ(ran.code, 1);
  EXPECT_NE(ran.output.find("another group's stereo is on this bus already"), std::string::npos)
      << ran.output;
}

}  // namespace
}  // namespace cairn::testing
