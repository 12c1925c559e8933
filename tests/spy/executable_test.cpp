// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/wait.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <random>

#include "bus/host_clock.hpp"
#include "bus/recording.hpp"
#include "network_namespace.hpp"
#include "spy/messages.hpp"
#include "temporary_folder.hpp"

namespace cairn::spy {
namespace {

namespace channels = bus::channels;
using nlohmann::json;
constexpr std::int64_t kStart_us = 1'700'000'000'000'000;

struct Outcome {
  int exit_code = -1;
  std::string printed;
};

Outcome finish(std::FILE* pipe, std::string printed = "") {
  std::array<char, 4096> buffer;
  while (const std::size_t size = std::fread(buffer.data(), 1, buffer.size(), pipe))
    printed.append(buffer.data(), size);
  const int status = ::pclose(pipe);
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, printed};
}

std::FILE* start_spy(const std::string& arguments) {
  return ::popen((CAIRN_BINARY_DIR "/bin/cairn-spy " + arguments).c_str(), "r");
}

Outcome spy(const std::string& arguments) { return finish(start_spy(arguments)); }

json named(const json& list, const std::string& key, const std::string& name) {
  for (const json& entry : list) {
    if (entry[key] == name) return entry;
  }
  ADD_FAILURE() << "no " << name << " in " << list.dump();
  return {};
}

class SpyExecutable : public ::testing::Test {
 protected:
  // Ten seconds: POSE at 20 Hz with every tenth lost and a restart in the middle, CLOCK at 100 Hz,
  // two statuses of the localizer, one cut message, one channel of others, LCM's self-test.
  void SetUp() override {
    path_ = folder_.path() / "run.lcmlog";
    auto writer = bus::RecordingWriter::create(path_).value();
    const auto write = [&](std::int64_t time_us, const bus::RawMessage& message) {
      ASSERT_TRUE(writer.write(kStart_us + time_us, message.channel, message.bytes));
    };
    write(0, {"LCM_SELF_TEST", {1, 2, 3}});
    for (int tick = 0; tick <= 1000; ++tick) {
      const std::int64_t time_us = tick * 10'000;
      write(time_us, message<channels::Clock>(5, tick));
      const int pose = tick / 5;
      const std::int64_t session = pose < 100 ? 1 : 2;
      if (tick % 5 == 0 && pose % 10 != 9)
        write(time_us, message<channels::Pose>(session, pose < 100 ? pose : pose - 100));
    }
    auto status = process_status("localizer", 1);
    status.pid = 77;
    write(10'000'000, {"PROCESS_STATUS", bytes_of(status)});
    status.header.session = 2;
    write(10'000'001, {"PROCESS_STATUS", bytes_of(status)});
    auto cut = message<channels::Goal>(9, 0);
    cut.bytes.pop_back();
    write(10'000'002, cut);
    write(10'000'003, {"FOREIGN", {0, 0, 0, 0, 0, 0, 0, 1}});
    ASSERT_TRUE(writer.flush());
  }

  testing::TemporaryFolder folder_;
  std::filesystem::path path_;
};

TEST_F(SpyExecutable, ReportsARecordingAsJson) {
  const Outcome outcome = spy("--log " + path_.string() + " --once --json");
  ASSERT_EQ(outcome.exit_code, 0);
  const json report = json::parse(outcome.printed);
  EXPECT_EQ(report["live"], false);
  EXPECT_EQ(report["source"], path_.string());
  EXPECT_EQ(report["damage"], (json{{"places", 0}, {"bytes", 0}}));
  EXPECT_NEAR(report["span_s"].get<double>(), 10, 1e-5);
  EXPECT_EQ(report["messages"], 1001 + 181 + 4);
  EXPECT_EQ(report["undecodable"], 2);

  const json pose = named(report["channels"], "channel", "POSE");
  EXPECT_EQ(pose["type"], "pose_t");
  EXPECT_EQ(pose["count"], 181);
  // 20 are missing; that the last of the first run is, nothing after it says.
  EXPECT_EQ(pose["lost"], 19);
  EXPECT_EQ(pose["out_of_order"], 0);
  EXPECT_EQ(pose["restarts"], 1);
  EXPECT_DOUBLE_EQ(pose["rate_hz"].get<double>(), 18);
  EXPECT_DOUBLE_EQ(pose["interval_ms"]["min"].get<double>(), 50);
  EXPECT_DOUBLE_EQ(pose["interval_ms"]["max"].get<double>(), 100);
  EXPECT_TRUE(pose["latency_ms"].is_null());
  EXPECT_EQ(pose["senders"][0]["process"], "localizer");
  EXPECT_EQ(pose["senders"][0]["session"], "0000000000000002");

  EXPECT_DOUBLE_EQ(named(report["channels"], "channel", "CLOCK")["rate_hz"].get<double>(), 100);
  EXPECT_TRUE(named(report["channels"], "channel", "GOAL")["rate_hz"].is_null());
  EXPECT_EQ(named(report["channels"], "channel", "FOREIGN")["in_catalogue"], false);

  ASSERT_EQ(report["processes"].size(), 1u);
  EXPECT_EQ(report["processes"][0]["process"], "localizer");
  EXPECT_EQ(report["processes"][0]["pid"], 77);
  EXPECT_EQ(report["processes"][0]["health"], "ok");
  EXPECT_EQ(report["processes"][0]["restarts"], 1);
}

TEST_F(SpyExecutable, PrintsATable) {
  const Outcome outcome = spy("--log " + path_.string());
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_NE(outcome.printed.find("localizer (restarted 1x)"), std::string::npos) << outcome.printed;
  EXPECT_NE(outcome.printed.find("GOAL: goal_t."), std::string::npos) << outcome.printed;
}

TEST_F(SpyExecutable, ShowsTheFieldsOfAChannel) {
  const json report =
      json::parse(spy("--log " + path_.string() + " --once --json --channel POSE").printed);
  EXPECT_EQ(report["message"]["type"], "pose_t");
  EXPECT_EQ(report["message"]["fields"]["header"]["sequence"], 100);
  const Outcome text = spy("--log " + path_.string() + " --once --channel POSE");
  EXPECT_NE(text.printed.find("POSE (pose_t)\nheader\n"), std::string::npos) << text.printed;
  const json none = json::parse(
      spy("--log " + path_.string() + " --once --json --channel NOBODY 2>/dev/null").printed);
  EXPECT_TRUE(none["message"].is_null());
}

TEST_F(SpyExecutable, ReportsARecordingThatWasCutShort) {
  std::ofstream(path_, std::ios::binary | std::ios::app) << std::string(20, '\x55');
  const json report = json::parse(spy("--log " + path_.string() + " --once --json").printed);
  EXPECT_EQ(report["damage"], (json{{"places", 1}, {"bytes", 20}}));
  EXPECT_EQ(report["messages"], 1001 + 181 + 4);
}

TEST_F(SpyExecutable, SurvivesARecordingWithAnyBytesChanged) {
  constexpr unsigned kSeed = 17;
  SCOPED_TRACE(kSeed);
  std::mt19937 random(kSeed);
  const auto damaged = folder_.path() / "damaged.lcmlog";
  for (int trial = 0; trial < 20; ++trial) {
    std::filesystem::copy_file(path_, damaged, std::filesystem::copy_options::overwrite_existing);
    const auto size = std::filesystem::file_size(path_);
    std::fstream file(damaged, std::ios::binary | std::ios::in | std::ios::out);
    for (int fault = 0; fault < 400; ++fault) {
      file.seekp(static_cast<std::streamoff>(random() % size));
      file.put(static_cast<char>(random()));
    }
    file.close();
    const Outcome outcome = spy("--log " + damaged.string() + " --once --json");
    ASSERT_EQ(outcome.exit_code, 0) << "trial " << trial;
    const json report = json::parse(outcome.printed);
    EXPECT_GT(report["undecodable"], 2);
    EXPECT_GT(report["messages"], 500);
  }
}

TEST_F(SpyExecutable, ExitCodesAreThoseOfTheCommandLine) {
  EXPECT_EQ(spy("--help").exit_code, 0);
  EXPECT_NE(spy("--help").printed.find("Example"), std::string::npos);
  EXPECT_EQ(spy("--no-such-option 2>/dev/null").exit_code, 2);
  EXPECT_EQ(spy("--seconds 1 2>/dev/null").exit_code, 2);
  EXPECT_EQ(spy("--once --seconds nan 2>/dev/null").exit_code, 2);
  EXPECT_EQ(spy("--log a --lcm-url b 2>/dev/null").exit_code, 2);
  EXPECT_EQ(spy("--log /nowhere/at/all 2>/dev/null").exit_code, 1);
  EXPECT_EQ(spy("--once --lcm-url nonsense:// 2>/dev/null").exit_code, 1);
}

class LiveSpy : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!testing::enter_network_namespace() || !testing::add_multicast_route())
      GTEST_SKIP() << testing::kNoNamespace;
  }
};

TEST_F(LiveSpy, ReportsWhatGoesOverTheBusMeanwhile) {
  const auto bus = bus::open_bus("").value();
  const bus::SteadyClock clock;
  std::FILE* pipe = start_spy("--once --seconds 1 --json");
  pollfd readable{::fileno(pipe), POLLIN, 0};
  for (int i = 0; ::poll(&readable, 1, 5) == 0; ++i) {
    const auto raw = message<channels::Clock>(1, i, clock.now_us());
    ASSERT_TRUE(bus->publish(raw.channel, raw.bytes));
  }
  const Outcome outcome = finish(pipe);
  ASSERT_EQ(outcome.exit_code, 0);
  const json report = json::parse(outcome.printed);
  EXPECT_EQ(report["live"], true);
  EXPECT_TRUE(report["damage"].is_null());
  const json channel = named(report["channels"], "channel", "CLOCK");
  EXPECT_GT(channel["count"], 1);
  EXPECT_EQ(channel["lost"], 0);
  EXPECT_EQ(channel["undecodable"], 0);
  EXPECT_GE(channel["latency_ms"]["p50"].get<double>(), 0);
}

TEST_F(LiveSpy, SilenceIsAnEmptyReportAndAHint) {
  const Outcome outcome = spy("--once --seconds 0.1 --json 2>&1 >/dev/null");
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_NE(outcome.printed.find("nothing heard on udpm://"), std::string::npos);
  const json report = json::parse(spy("--once --seconds 0.1 --json 2>/dev/null").printed);
  EXPECT_EQ(report["messages"], 0);
  EXPECT_TRUE(report["channels"].empty());
}

}  // namespace
}  // namespace cairn::spy
