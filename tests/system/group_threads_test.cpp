// SPDX-License-Identifier: Apache-2.0
// The robot's nodes, two of them at work at any moment: under the thread sanitizer this looks for
// data that two share.
#include <gtest/gtest.h>

#include "system/demo_runs.hpp"
#include "system/small_worlds.hpp"
#include "temporary_folder.hpp"

namespace cairn::testing {
namespace {

namespace fs = std::filesystem;

TEST(GroupThreads, TheRobotsNodesWorkTwoAtATimeAsOneByOne) {
  const TemporaryFolder folder;
  const fs::path world = small_world(folder.path(), kCrate);
  const auto trajectory_on = [&](const std::string& threads) {
    const fs::path out = folder.path() / threads;
    const Ran ran = run_cairn({"demo", "--fast", "--world", world, "--time-limit", "3", "--threads",
                               threads, "--out", out});
    EXPECT_EQ(report_of(out)["reason"], "stopped at the time limit") << ran.output;
    EXPECT_EQ(ran.output.find("Sanitizer"), std::string::npos) << ran.output;
    return text_of(out / "trajectory.tum");
  };
  const std::string one_by_one = trajectory_on("1");
  EXPECT_GT(one_by_one.size(), 1'000U);
  EXPECT_EQ(trajectory_on("2"), one_by_one);
}

}  // namespace
}  // namespace cairn::testing
