// SPDX-License-Identifier: Apache-2.0
// The robot's own group as it ships, with a folder of images in place of its webcams and the
// reference firmware on a pseudo-terminal in place of its wheels, all by the words that people use.
#include <gtest/gtest.h>
#include <poll.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "bus/host_clock.hpp"
#include "core/child_process.hpp"
#include "mapping/map_file.hpp"
#include "motor/wheel_rig.hpp"
#include "network_namespace.hpp"
#include "simulation/pseudo_terminal.hpp"
#include "supervisor/processes_of_run.hpp"
#include "system/recordings_of_tests.hpp"
#include "temporary_folder.hpp"

namespace cairn::testing {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

struct Answer {
  int exit_code = 0;
  std::string text;
};

class RobotGroup : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!enter_network_namespace() || !add_multicast_route()) GTEST_SKIP() << kNoNamespace;
    wheels_.emplace(simulation::PseudoTerminal::open(folder_.path() / "wheels").value(), 7,
                    clock_.now_us());
  }
  void TearDown() override { kill_processes_of(run_); }

  /// Plays the wheels for so long as it is not so.
  template <class Condition>
  void play_until(Condition so) {
    while (!so()) {
      wheels_->run(clock_.now_us());
      ::poll(nullptr, 0, 2);
    }
  }

  /// `cairn` with these words; the wheels go on meanwhile.
  Answer cairn(std::vector<std::string> words) {
    const fs::path output = folder_.path() / "answer";
    fs::remove(output);
    words.insert(words.begin(), program("cairn-cli"));
    auto child = ChildProcess::start(words, output);
    EXPECT_TRUE(child) << child.error().message;
    play_until([&] { return child->exit_code().has_value(); });
    std::ifstream file(output);
    std::ostringstream text;
    text << file.rdbuf();
    return {*child->exit_code(), text.str()};
  }

  Answer up(std::vector<std::string> more = {}) {
    std::vector<std::string> words{
        "up",    fs::path(CAIRN_SOURCE_DIR) / "config/groups/robot.yaml",
        "--out", run_,
        "--set", "camera.source=dataset",
        "--set", "camera.dataset=" + rendered_room().string(),
        "--set", "camera.speed=0.3",
        "--set", "motor.device=" + (folder_.path() / "wheels").string(),
        "--set", "motor.latch_file=" + (folder_.path() / "latch").string(),
        "--set", "mapper.resolution_m=0.05"};
    words.insert(words.end(), more.begin(), more.end());
    return cairn(words);
  }

  Json ps() {
    const Answer answer = cairn({"ps", "--json"});
    EXPECT_EQ(answer.exit_code, 0) << answer.text;
    return Json::parse(answer.text, nullptr, false);
  }
  static Json row(const Json& ps, const std::string& process) {
    for (const Json& row : ps.at("processes")) {
      if (row.at("process") == process) return row;
    }
    return Json::object();
  }

  TemporaryFolder folder_;
  fs::path run_ = folder_.path() / "run";
  bus::SteadyClock clock_;
  std::optional<WheelRig> wheels_;
};

TEST_F(RobotGroup, ComesUpIsShownIsTendedAndEndsWithItsMapSaved) {
  const Answer up_answer = up();
  ASSERT_EQ(up_answer.exit_code, 0) << up_answer.text;
  EXPECT_NE(up_answer.text.find("ready: 8 processes; run folder " + run_.string()),
            std::string::npos)
      << up_answer.text;

  Json shown;
  play_until([&] {
    shown = ps();
    return row(shown, "mapper").at("health") == "ok" || fs::exists(run_ / "state/mapper/map.cairn");
  });
  EXPECT_TRUE(shown.at("ready").get<bool>()) << shown.dump(1);
  EXPECT_FALSE(shown.at("moves").get<bool>());
  EXPECT_TRUE(shown.at("motion").get<std::string>().starts_with("holds still: ")) << shown.dump(1);
  for (const char* process : {"camera", "stereo", "odometry", "localizer", "mapper", "planner",
                              "guard", "motor", "supervisor"}) {
    const Json one = row(shown, process);
    EXPECT_EQ(one.at("state"), "running") << process;
    EXPECT_EQ(one.at("restarts"), 0) << process;
    EXPECT_GT(one.at("pid").get<int>(), 1) << process;
    EXPECT_GT(one.at("rss_bytes").get<std::int64_t>(), 1'000'000) << process;
    EXPECT_GE(one.at("cpu_share").get<double>(), 0) << process;
    EXPECT_LE(one.at("cpu_share").get<double>(), 2) << process;
    EXPECT_GT(one.at("uptime_s").get<double>(), 0) << process;
    EXPECT_NE(one.at("health"), "ill") << process << ": " << one.dump();
  }
  EXPECT_GT(row(shown, "stereo").at("cpu_share").get<double>(), 0);

  EXPECT_EQ(cairn({"stop", "planner"}).text,
            "planner: stopped by hand; ./cairn start planner runs it again\n");
  EXPECT_EQ(row(ps(), "planner").at("state"), "stopped");
  const Answer started = cairn({"start", "planner"});
  EXPECT_EQ(started.exit_code, 0) << started.text;
  EXPECT_TRUE(started.text.starts_with("planner: running (pid ")) << started.text;
  const pid_t mapper = row(ps(), "mapper").at("pid").get<int>();
  const Answer restarted = cairn({"restart", "mapper"});
  EXPECT_EQ(restarted.exit_code, 0) << restarted.text;
  shown = ps();
  EXPECT_NE(row(shown, "mapper").at("pid").get<int>(), mapper);
  EXPECT_EQ(row(shown, "mapper").at("restarts"), 1);
  const Answer printed = cairn({"output", "mapper", "-n", "100"});
  EXPECT_NE(printed.text.find("info mapper: ready"), std::string::npos) << printed.text;
  EXPECT_NE(printed.text.find("supervisor: mapper: restarted by hand"), std::string::npos)
      << printed.text;

  const Answer nobody = cairn({"restart", "maper"});
  EXPECT_EQ(nobody.exit_code, 1);
  EXPECT_EQ(nobody.text,
            "the group has no process 'maper'; it has camera, stereo, odometry, localizer, mapper, "
            "planner, guard, motor\n");

  const Answer down = cairn({"down"});
  EXPECT_EQ(down.exit_code, 0) << down.text;
  EXPECT_EQ(down.text, "ended; run folder " + run_.string() +
                           "\nmap: " + (run_ / "state/mapper/map.cairn").string() + "\n");
  play_until([&] { return processes_of(run_).empty(); });
  const auto map = mapping::load_map(run_ / "state/mapper/map.cairn", {});
  ASSERT_TRUE(map) << map.error().message;
  EXPECT_GT(map->map.occupied_voxels(), 100U);

  // A run of an ended group is shown by its folder alone.
  EXPECT_NE(cairn({"output", "stereo", "--out", run_}).text.find("ready"), std::string::npos);
  const Answer none = cairn({"ps"});
  EXPECT_EQ(none.exit_code, 1);
  EXPECT_TRUE(none.text.starts_with("no supervisor is heard on udpm://239.255.76.67:7667"))
      << none.text;
}

TEST_F(RobotGroup, BeginsWithAMapAndLeavesItAsItIs) {
  ASSERT_EQ(up().exit_code, 0);
  play_until([&] {
    const auto map = mapping::load_map(run_ / "state/mapper/map.cairn", {});
    return map.has_value() && map->map.occupied_voxels() > 100;
  });
  ASSERT_EQ(cairn({"down"}).exit_code, 0);
  const fs::path map = folder_.path() / "kept.cairn";
  fs::copy_file(run_ / "state/mapper/map.cairn", map);
  const auto before = mapping::load_map(map, {});
  ASSERT_TRUE(before);
  const Answer again = up({"--map", map, "--localize-only"});
  ASSERT_EQ(again.exit_code, 0) << again.text;
  play_until([&] { return fs::exists(run_ / "state/mapper/map.cairn"); });
  ASSERT_EQ(cairn({"down"}).exit_code, 0);
  const auto after = mapping::load_map(run_ / "state/mapper/map.cairn", {});
  ASSERT_TRUE(after) << after.error().message;
  EXPECT_EQ(after->info.map_id, before->info.map_id);
  EXPECT_EQ(after->info.last_utime, before->info.last_utime);
  EXPECT_EQ(after->map.occupied_voxels(), before->map.occupied_voxels());
}

TEST_F(RobotGroup, WhatIsNotReadyIsSaidWithItsReason) {
  wheels_.emplace(simulation::PseudoTerminal::open(folder_.path() / "other").value(), 7,
                  clock_.now_us());
  const Answer answer = up();
  EXPECT_EQ(answer.exit_code, 1);
  EXPECT_NE(answer.text.find("not ready:\n  motor: ill: "), std::string::npos) << answer.text;
  EXPECT_NE(answer.text.find("wheels"), std::string::npos) << answer.text;
  EXPECT_TRUE(ps().at("motion").get<std::string>().starts_with("holds still: no wheels"));
  EXPECT_EQ(cairn({"down"}).exit_code, 0);
}

TEST_F(RobotGroup, WhatCannotWorkIsRefusedBeforeAnythingStarts) {
  const Answer misspelt = up({"--set", "mapper.resolutoin_m=0.1", "--set", "stereo.method=magic"});
  EXPECT_EQ(misspelt.exit_code, 2);
  EXPECT_NE(misspelt.text.find("resolutoin_m: unknown key (did you mean 'resolution_m'?)"),
            std::string::npos)
      << misspelt.text;
  EXPECT_NE(misspelt.text.find("'magic' is not known"), std::string::npos) << "all at once";
  const Answer nobody = up({"--set", "wheels.x=1"});
  EXPECT_EQ(nobody.exit_code, 2);
  EXPECT_NE(nobody.text.find("PROCESS one of camera, stereo"), std::string::npos) << nobody.text;
  const Answer no_map = up({"--localize-only"});
  EXPECT_EQ(no_map.exit_code, 2);
  EXPECT_NE(no_map.text.find("--map FILE"), std::string::npos) << no_map.text;
  std::ofstream(folder_.path() / "map") << "no map";
  EXPECT_EQ(up({"--map", folder_.path() / "map"}).exit_code, 2);
  std::ofstream(folder_.path() / "bad.yaml") << "processes:\n  - nmae: stereo\n";
  const Answer bad = cairn({"up", folder_.path() / "bad.yaml"});
  EXPECT_EQ(bad.exit_code, 2);
  EXPECT_NE(bad.text.find("bad.yaml:2: processes[0].nmae: unknown key (did you mean 'name'?)"),
            std::string::npos)
      << bad.text;
  EXPECT_FALSE(fs::exists(run_)) << "nothing was made";
}

}  // namespace
}  // namespace cairn::testing
