// SPDX-License-Identifier: Apache-2.0
// The whole robot in a small room: it explores by itself, also when its processes die, and its
// recording is the same run again.
#include <gtest/gtest.h>

#include <csignal>
#include <iostream>

#include "network_namespace.hpp"
#include "procs/cli/group_client.hpp"
#include "system/demo_runs.hpp"
#include "system/live_group.hpp"
#include "system/recordings_of_tests.hpp"
#include "system/small_worlds.hpp"
#include "temporary_folder.hpp"

namespace cairn::testing {
namespace {

namespace fs = std::filesystem;

class LiveDemo : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!enter_network_namespace() || !add_multicast_route()) GTEST_SKIP() << kNoNamespace;
  }

  [[nodiscard]] std::vector<std::string> demo(const std::string& boxes) const {
    return {"demo",      "--headless", "--world",      small_world(folder_.path(), boxes),
            "--lcm-url", kStockUrl,    "--time-limit", "500",
            "--out",     out()};
  }
  [[nodiscard]] fs::path out() const { return folder_.path() / "out"; }

  void expect_good(const Ran& ran) const {
    ASSERT_EQ(ran.code, 0) << ran.output;
    const auto report = report_of(out());
    std::cout << report.dump() << "\n";
    EXPECT_EQ(report["finished"], true);
    EXPECT_EQ(report["mode"], "full");
    EXPECT_GE(report["coverage"], 0.85);
    EXPECT_EQ(report["collisions"], 0);
    EXPECT_EQ(total(report["dropped"]), 0) << report["dropped"].dump();
    EXPECT_LE(report["trajectory"]["ate_rmse_m"], 0.1);
    EXPECT_GE(report["map"]["precision"], 0.85);
    EXPECT_GE(report["map"]["recall"], 0.85);
    EXPECT_TRUE(report["latency_ms"]["frame_to_pose"]["p99"].is_number());
    EXPECT_TRUE(report["latency_ms"]["frame_to_correction"]["p99"].is_number());
    EXPECT_TRUE(report["latency_ms"]["frame_to_map"]["p99"].is_number());
    for (const char* file : {"map.png", "map.cairn", "trajectory.tum", "trajectory_final.tum",
                             "truth.tum", "recording.lcmlog", "config.yaml"}) {
      EXPECT_TRUE(fs::exists(out() / file)) << file;
    }
  }

  // The inputs of the recording, by lcm-logplayer into live processes of their own.
  [[nodiscard]] fs::path play_into_live_processes() {
    const fs::path state = folder_.path() / "again";
    LiveGroup group(rendered_room());
    for (const std::string& process : kWithoutCamera) {
      group.start(process, {program("cairn-" + process), "--lcm-url", kStockUrl, "--state",
                            state / process, "--config", out() / "config.yaml"});
    }
    EXPECT_TRUE(group.listen_until_heard(kWithoutCamera));
    group.start("lcm-logplayer", {"/usr/bin/lcm-logplayer", "-l", kStockUrl, "-e",
                                  "^(STEREO_FRAME|CALIBRATION|WHEEL_STATE|RANGE|CLOCK)$",
                                  out() / "recording.lcmlog"});
    EXPECT_EQ(group.wait("lcm-logplayer"), 0) << group.output("lcm-logplayer");
    group.listen_until_quiet();
    group.stop();
    // Beside the map, so that the one run can be laid over the other.
    EXPECT_TRUE(evaluation::write_tum(state / "mapper/trajectory.tum", group.heard().trajectory()));
    return state / "mapper/map.cairn";
  }

  TemporaryFolder folder_;
};

TEST_F(LiveDemo, ExploresARoomAndItsRecordingIsTheSameRunAgain) {
  const Ran ran = run_cairn(demo(""));
  expect_good(ran);
  const fs::path again = folder_.path() / "lockstep";
  const Ran replayed = run_cairn(
      {"replay", out() / "recording.lcmlog", "--lockstep", "--threads", "2", "--out", again});
  ASSERT_EQ(replayed.code, 0) << replayed.output;
  const double agreement = f_score(again / "map.cairn", out() / "map.cairn");
  const bool whole = total(report_of(out())["skipped"]) == 0;
  std::cout << "lockstep: F-score " << agreement << (whole ? ", nothing was skipped\n" : "\n");
  EXPECT_GE(agreement, 0.9);
  if (whole) {
    EXPECT_EQ(text_of(again / "trajectory.tum"), text_of(out() / "trajectory.tum"));
  }
  const double live = f_score(play_into_live_processes(), out() / "map.cairn");
  std::cout << "lcm-logplayer: F-score " << live << "\n";
  EXPECT_GE(live, 0.9);
}

// Not reached yet: all processes come back and nothing is lost, but the planner then ends the
// exploration of this small room too early (coverage 0.77).
TEST_F(LiveDemo, DISABLED_GoesOnWhicheverOfItsProcessesIsKilled) {
  const std::vector<std::string> victims{"stereo",  "odometry", "localizer", "mapper",
                                         "planner", "guard",    "motor"};
  LiveGroup listener(rendered_room());
  cli::GroupClient group(listener.node());
  auto words = demo(kChest);
  words.insert(words.begin(), program("cairn-cli"));
  listener.start("demo", words);
  ASSERT_TRUE(listener.listen_until([&] { return group.ready(); })) << listener.output("demo");
  std::int64_t frames = listener.heard().frames();
  // Now and then, and each only once all others are well again.
  const auto after_more_frames = [&] {
    frames += 45;
    return listener.listen_until(
        [&] { return group.ready() && listener.heard().frames() >= frames; });
  };
  for (const std::string& victim : victims) {
    ASSERT_TRUE(after_more_frames()) << "before " << victim << ": " << listener.output("demo");
    ASSERT_NE(group.find(victim), nullptr);
    ASSERT_EQ(::kill(group.find(victim)->pid, SIGKILL), 0) << victim;
    ASSERT_TRUE(listener.listen_until([&] { return !group.ready(); })) << victim;
  }
  ASSERT_TRUE(after_more_frames()) << listener.output("demo");
  ASSERT_EQ(::kill(group.state()->pid, SIGKILL), 0) << "supervisor";
  ASSERT_TRUE(listener.listen_until([&] { return fs::exists(out() / "report.json"); }, 600));
  const int code = listener.wait("demo");
  expect_good({code, listener.output("demo")});
  EXPECT_GE(report_of(out())["trajectory"]["length_m"], 1.0) << "it drove";
  const auto restarts = report_of(out())["restarts"];
  for (const std::string& victim : victims) EXPECT_EQ(restarts[victim], 1) << victim;
  EXPECT_EQ(restarts["supervisor"], 1);
  EXPECT_EQ(restarts["simulator"], 0);
}

}  // namespace
}  // namespace cairn::testing
