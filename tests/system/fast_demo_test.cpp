// SPDX-License-Identifier: Apache-2.0
// Fast demos are the same again for the same seed, and nothing on the robot reads the truth.
#include <gtest/gtest.h>

#include "system/demo_runs.hpp"
#include "system/small_worlds.hpp"
#include "temporary_folder.hpp"

namespace cairn::testing {
namespace {

namespace fs = std::filesystem;

class FastDemo : public ::testing::Test {
 protected:
  // The first seconds of a fast demo; what it published as trajectory.
  std::string trajectory(const std::vector<std::string>& words) {
    const fs::path out = folder_.path() / std::to_string(runs_++);
    std::vector<std::string> command{"demo",         "--fast", "--world", world_,
                                     "--time-limit", "25",     "--out",   out};
    command.insert(command.end(), words.begin(), words.end());
    const Ran ran = run_cairn(command);
    EXPECT_TRUE(fs::exists(out / "report.json")) << ran.output;
    out_ = out;
    return text_of(out / "trajectory.tum");
  }

  TemporaryFolder folder_;
  fs::path world_ = small_world(folder_.path(), kCrate);
  fs::path out_;  ///< of the newest run
  int runs_ = 0;
};

TEST_F(FastDemo, TheSameSeedIsTheSameRunOnAnyNumberOfThreadsAndAnotherIsAnother) {
  const std::string once = trajectory({"--seed", "7", "--threads", "1"});
  const std::string map = text_of(out_ / "map.cairn");
  EXPECT_GT(once.size(), 10'000U);
  EXPECT_FALSE(map.empty());
  EXPECT_EQ(trajectory({"--seed", "7", "--threads", "2"}), once);
  EXPECT_EQ(text_of(out_ / "map.cairn"), map);
  EXPECT_NE(trajectory({"--seed", "8"}), once);
}

TEST_F(FastDemo, WithTheTruthUnpublishedTheRobotDoesTheSame) {
  const std::string told = trajectory({});
  EXPECT_TRUE(report_of(out_)["coverage"].is_number());
  EXPECT_EQ(trajectory({"--set", "simulator.publish_truth=false"}), told);
  const auto report = report_of(out_);
  EXPECT_TRUE(report["coverage"].is_null()) << "nobody can know";
  EXPECT_TRUE(report["collisions"].is_null());
  EXPECT_TRUE(report["trajectory"]["ate_rmse_m"].is_null());
}

TEST_F(FastDemo, ExploresTheWholeRoomAndSaysThatItWasFast) {
  const fs::path out = folder_.path() / "whole";
  const Ran ran = run_cairn({"demo", "--fast", "--world", world_, "--out", out});
  EXPECT_EQ(ran.code, 0) << ran.output;
  EXPECT_NE(ran.output.find("FAST"), std::string::npos) << ran.output;
  const auto report = report_of(out);
  EXPECT_EQ(report["finished"], true);
  EXPECT_EQ(report["mode"], "fast");
  EXPECT_EQ(report["collisions"], 0);
  EXPECT_EQ(total(report["skipped"]), 0);
  EXPECT_GE(report["coverage"], 0.85);
  EXPECT_LE(report["trajectory"]["ate_rmse_m"], 0.1);
  EXPECT_TRUE(report["latency_ms"]["frame_to_pose"].is_null()) << "its time is not life's";
}

TEST_F(FastDemo, AtTheTimeLimitItEndsUnfinishedWithWhatItHas) {
  const fs::path out = folder_.path() / "short";
  const Ran ran =
      run_cairn({"demo", "--fast", "--world", world_, "--time-limit", "5", "--out", out});
  EXPECT_EQ(ran.code, 1) << ran.output;
  const auto report = report_of(out);
  EXPECT_EQ(report["finished"], false);
  EXPECT_EQ(report["reason"], "stopped at the time limit");
  for (const char* file : {"map.png", "map.cairn", "trajectory.tum", "trajectory_final.tum",
                           "truth.tum", "recording.lcmlog", "config.yaml"}) {
    EXPECT_TRUE(fs::exists(out / file)) << file;
  }
}

}  // namespace
}  // namespace cairn::testing
