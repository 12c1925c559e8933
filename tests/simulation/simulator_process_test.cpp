// SPDX-License-Identifier: Apache-2.0
// The program itself: how it begins and how it ends.
#include <gtest/gtest.h>
#include <sched.h>

#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "core/child_process.hpp"
#include "network_namespace.hpp"
#include "scenes.hpp"
#include "temporary_folder.hpp"

namespace cairn::simulation {
namespace {

namespace fs = std::filesystem;

class SimulatorProcess : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    has_namespace_ =
        cairn::testing::enter_network_namespace() && cairn::testing::add_multicast_route();
  }
  void SetUp() override {
    if (!has_namespace_) GTEST_SKIP() << cairn::testing::kNoNamespace;
  }

  [[nodiscard]] ChildProcess start(const std::vector<std::string>& settings) {
    fs::remove(output_);
    std::vector<std::string> command{
        std::string(CAIRN_BINARY_DIR) + "/bin/cairn-simulator", "--set",
        "rig=" + std::string(CAIRN_SOURCE_DIR) + "/config/calibration/simulated-25cm.yaml", "--set",
        "wheel_device=" + link_.string()};
    for (const std::string& setting : settings) {
      command.emplace_back("--set");
      command.push_back(setting);
    }
    return ChildProcess::start(command, output_).value();
  }

  [[nodiscard]] std::string output() const {
    std::ifstream file(output_);
    std::ostringstream text;
    text << file.rdbuf();
    return text.str();
  }

  /// False if it does not come true within what even a slow machine needs.
  template <class Condition>
  static bool comes_true(Condition&& condition) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(60);
    while (!condition()) {
      if (std::chrono::steady_clock::now() > end) return false;
      ::sched_yield();
    }
    return true;
  }

  [[nodiscard]] bool gets_ready() const {
    return comes_true([&] { return output().find("ready") != std::string::npos; });
  }
  static std::optional<int> end_of(ChildProcess& child) {
    std::optional<int> code;
    (void)comes_true([&] { return (code = child.exit_code()).has_value(); });
    return code;
  }

  cairn::testing::TemporaryFolder folder_;
  fs::path link_ = folder_.path() / "run" / "wheels";
  fs::path output_ = folder_.path() / "output";
  std::string world_ = "world=" + room_file().string();

 private:
  static inline bool has_namespace_ = false;
};

TEST_F(SimulatorProcess, EndsCleanlyWhenToldAndTakesItsLinkWithIt) {
  for (const int signal : {SIGTERM, SIGINT}) {
    auto child = start({world_});
    ASSERT_TRUE(gets_ready()) << output();
    EXPECT_TRUE(fs::is_symlink(link_));
    child.signal(signal);
    EXPECT_EQ(end_of(child), 0) << output();
    EXPECT_FALSE(fs::exists(fs::symlink_status(link_)));
  }
}

TEST_F(SimulatorProcess, KilledAndStartedAnewItTakesTheLinkThatIsLeft) {
  auto killed = start({world_});
  ASSERT_TRUE(gets_ready()) << output();
  killed.signal(SIGKILL);
  EXPECT_EQ(end_of(killed), -SIGKILL);
  EXPECT_TRUE(fs::is_symlink(link_));
  auto again = start({world_});
  ASSERT_TRUE(gets_ready()) << output();
  EXPECT_TRUE(fs::exists(link_)) << "leads nowhere";
  again.signal(SIGTERM);
  EXPECT_EQ(end_of(again), 0);
}

TEST_F(SimulatorProcess, AWorldThatDoesNotServeEndsItWithTheReason) {
  auto missing = start({"world=no/such/world.yaml"});
  EXPECT_EQ(end_of(missing), 1);
  EXPECT_NE(output().find("no/such/world.yaml"), std::string::npos) << output();
  const fs::path broken = folder_.path() / "broken.yaml";
  std::ofstream(broken) << "boxes:\n  - {name: floor, centre_m: [0, 0, zero]}\n";
  auto malformed = start({"world=" + broken.string()});
  EXPECT_EQ(end_of(malformed), 1);
  EXPECT_NE(output().find(broken.string() + ":2"), std::string::npos) << output();
  auto none = start({});
  EXPECT_EQ(end_of(none), 2);
  EXPECT_NE(output().find("simulator.world"), std::string::npos) << output();
}

}  // namespace
}  // namespace cairn::simulation
