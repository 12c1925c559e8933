// SPDX-License-Identifier: Apache-2.0
// The robot's nodes, two of them at work at any moment: under the thread sanitizer this looks for
// data that two share.
#include <gtest/gtest.h>

#include "system/demo_runs.hpp"
#include "system/recordings_of_tests.hpp"
#include "system/small_worlds.hpp"
#include "temporary_folder.hpp"

namespace cairn::testing {
namespace {

namespace fs = std::filesystem;

class GroupThreads : public ::testing::Test {
 protected:
  // What `cairn WORDS...` makes of a run on so many threads.
  std::string trajectory(std::vector<std::string> words, const std::string& threads) {
    const fs::path out = folder_.path() / threads;
    words.insert(words.end(), {"--threads", threads, "--out", out});
    const Ran ran = run_cairn(words);
    EXPECT_TRUE(fs::exists(out / "report.json")) << ran.output;
    EXPECT_EQ(ran.output.find("Sanitizer"), std::string::npos) << ran.output;
    return text_of(out / "trajectory.tum");
  }

  void expect_the_same_on_two_threads(const std::vector<std::string>& words) {
    const std::string one_by_one = trajectory(words, "1");
    EXPECT_GT(one_by_one.size(), 300U);
    EXPECT_EQ(trajectory(words, "2"), one_by_one);
  }

  TemporaryFolder folder_;
};

TEST_F(GroupThreads, ThatDriveWorkTwoAtATimeAsOneByOne) {
  const fs::path world = small_world(folder_.path(), kCrate);
  expect_the_same_on_two_threads({"demo", "--fast", "--world", world, "--time-limit", "3"});
}

TEST_F(GroupThreads, ThatSeeWorkTwoAtATimeAsOneByOne) {
  const fs::path dataset = folder_.path() / "dataset";
  render_room(dataset, 8);
  expect_the_same_on_two_threads({"replay", dataset, "--lockstep"});
}

}  // namespace
}  // namespace cairn::testing
