// SPDX-License-Identifier: Apache-2.0
// The same recording through live processes and through lockstep; on a stock kernel's buffers;
// through lcm-logger and lcm-logplayer; with a stranger's stereo.
#include <gtest/gtest.h>

#include <cstdlib>
#include <iostream>

#include "bus/recording.hpp"
#include "core/atomic_file.hpp"
#include "network_namespace.hpp"
#include "procs/cli/lockstep_run.hpp"
#include "system/end_error.hpp"
#include "system/live_group.hpp"
#include "system/recordings_of_tests.hpp"

namespace cairn::testing {
namespace {

namespace fs = std::filesystem;

std::uint64_t sum(const std::map<std::string, std::uint64_t>& counts) {
  std::uint64_t total = 0;
  for (const auto& [channel, count] : counts) total += count;
  return total;
}

// Into a new folder; of a test's own, so it needs no lock.
cli::RunPlan lockstep_plan(const fs::path& source, const fs::path& out, int threads) {
  cli::RunPlan plan;
  plan.source = source;
  plan.out = out;
  plan.threads = threads;
  fs::create_directories(out);
  return cli::complete(plan).value();
}

std::vector<std::uint8_t> bytes_of(const fs::path& path) {
  auto bytes = read_file(path);
  EXPECT_TRUE(bytes) << bytes.error().message;
  return bytes.value_or(std::vector<std::uint8_t>{});
}

class GroupTest : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!enter_network_namespace() || !add_multicast_route()) GTEST_SKIP() << kNoNamespace;
  }

  // Plays the dataset through camera, stereo, odometry and mapper.
  static void run(LiveGroup& group) {
    for (const std::string& process : kWithoutCamera) group.start(process);
    ASSERT_TRUE(group.listen_until_heard(kWithoutCamera));
    group.start("camera");
    ASSERT_EQ(group.wait("camera"), 0) << group.output("camera");
    group.listen_until_quiet();
    group.stop();
  }

  // A run in which nothing was skipped or lost equals lockstep; on a busy machine only a slower one
  // is such a run. (That nothing is lost on busy cores is another test's.)
  static void expect_live_equals_lockstep(const fs::path& dataset) {
    TemporaryFolder folder;
    ASSERT_TRUE(cli::run_lockstep(lockstep_plan(dataset, folder.path() / "one", 1)));
    ASSERT_TRUE(cli::run_lockstep(lockstep_plan(dataset, folder.path() / "two", 2)));
    const auto trajectory = bytes_of(folder.path() / "one/trajectory.tum");
    const auto map = bytes_of(folder.path() / "one/map.cairn");
    EXPECT_EQ(bytes_of(folder.path() / "two/trajectory.tum"), trajectory) << "one and two threads";
    EXPECT_EQ(bytes_of(folder.path() / "two/map.cairn"), map) << "one and two threads";
    for (const double speed : {1.0, 0.5, 0.25, 0.1}) {
      LiveGroup group(dataset, speed);
      run(group);
      const std::uint64_t missed = sum(group.heard().skipped()) + sum(group.heard().lost());
      std::cout << "at speed " << speed << " " << missed << " messages were skipped or lost\n";
      if (missed > 0) continue;
      const std::string live = evaluation::tum_text(group.heard().trajectory());
      EXPECT_EQ(std::vector<std::uint8_t>(live.begin(), live.end()), trajectory);
      EXPECT_EQ(bytes_of(group.map()), map);
      return;
    }
    FAIL() << "even at a tenth of life's speed messages were skipped or lost";
  }
};

TEST_F(GroupTest, LiveEqualsLockstepByteForByteInARenderedRoom) {
  expect_live_equals_lockstep(rendered_room());
}

TEST_F(GroupTest, LiveEqualsLockstepByteForByteInARealStreet) {
  const auto street = real_street();
  if (!street) GTEST_SKIP() << kNoStreet;
  expect_live_equals_lockstep(*street);
}

// H-BUS-2: a machine that has better things to do.
TEST_F(GroupTest, OnAStockKernelsBufferWithBusyCoresNothingIsLost) {
  const fs::path dataset = real_street().value_or(rendered_room());
  LiveGroup group(dataset);
  for (const char* name : {"busy_a", "busy_b"})
    group.start(name, {"/bin/sh", "-c", "while :; do :; done"});
  run(group);
  for (const auto& [channel, count] : group.heard().lost()) EXPECT_EQ(count, 0U) << channel;
  const double error = end_error_fraction(group.heard().trajectory(), dataset);
  std::cout << "off by " << 100 * error << " % of the way; " << sum(group.heard().skipped())
            << " messages skipped\n";
  EXPECT_LE(error, 0.02);
}

TEST_F(GroupTest, WhatLcmLoggerCapturedPlaysAgainByLockstepAndByLcmLogplayer) {
  const fs::path dataset = real_street().value_or(rendered_room());
  TemporaryFolder folder;
  const fs::path log = folder.path() / "run.lcmlog";
  {
    LiveGroup group(dataset);
    group.start("lcm-logger", {"/usr/bin/lcm-logger", "-q", "--lcm-url", kStockUrl, log});
    run(group);
  }
  // By lockstep: the inputs that were captured make the same run again.
  ASSERT_TRUE(cli::run_lockstep(lockstep_plan(dataset, folder.path() / "dataset", 1)));
  ASSERT_TRUE(cli::run_lockstep(lockstep_plan(log, folder.path() / "log", 1)));
  EXPECT_EQ(bytes_of(folder.path() / "log/trajectory.tum"),
            bytes_of(folder.path() / "dataset/trajectory.tum"));

  // By lcm-logplayer, into a live group without a camera.
  LiveGroup group(dataset);
  for (const std::string& process : kWithoutCamera) group.start(process);
  ASSERT_TRUE(group.listen_until_heard(kWithoutCamera));
  group.start("lcm-logplayer", {"/usr/bin/lcm-logplayer", "-l", kStockUrl, "-e",
                                "^(STEREO_FRAME|CALIBRATION|WHEEL_STATE|RANGE|CLOCK)$", log});
  ASSERT_EQ(group.wait("lcm-logplayer"), 0) << group.output("lcm-logplayer");
  group.listen_until_quiet();
  group.stop();
  const double error = end_error_fraction(group.heard().trajectory(), dataset);
  std::cout << "off by " << 100 * error << " % of the way\n";
  EXPECT_LE(error, 0.02);
}

TEST_F(GroupTest, AStrangersStereoTakesOverAndTheMapGoesOnGrowing) {
  LiveGroup group(rendered_room(), 0.5);
  std::int64_t mapped = 0;
  group.node().on<bus::channels::ProcessStatus>([&](const process_status_t& status) {
    if (status.process != "mapper") return;
    for (const counter_t& counter : status.counters) {
      if (counter.name == "frames_mapped") mapped = counter.value;
    }
  });
  for (const std::string& process : kWithoutCamera) group.start(process);
  ASSERT_TRUE(group.listen_until_heard(kWithoutCamera));
  group.start("camera");
  ASSERT_TRUE(group.listen_until([&] { return mapped > 5; }));
  group.kill("stereo", SIGTERM);
  group.start("stranger", {program("strangers_stereo"), kStockUrl});
  const std::int64_t before = mapped;
  EXPECT_TRUE(group.listen_until([&] { return mapped > before + 10; })) << group.output("mapper");
  group.wait("camera");
  group.kill("stranger");
  group.stop();
  EXPECT_EQ(group.heard().refused()["DISPARITY"], 0U) << group.output("mapper");
}

}  // namespace
}  // namespace cairn::testing
