// SPDX-License-Identifier: Apache-2.0
// What people and networks do to programs: each is a clear message or a counted refusal, never a
// crash.
#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <fstream>
#include <random>
#include <sstream>

#include "bus/recording.hpp"
#include "core/atomic_file.hpp"
#include "network_namespace.hpp"
#include "system/live_group.hpp"
#include "system/recordings_of_tests.hpp"

namespace cairn::testing {
namespace {

namespace fs = std::filesystem;

/// Runs a program to its end.
struct Ran {
  int code = 0;
  std::string output;
};
Ran run(const TemporaryFolder& folder, const std::vector<std::string>& command) {
  const fs::path output = folder.path() / "output";
  fs::remove(output);
  auto child = ChildProcess::start(command, output).value();
  std::optional<int> code;
  while (!(code = child.exit_code())) ::sched_yield();
  std::ifstream file(output);
  std::ostringstream text;
  text << file.rdbuf();
  return {*code, text.str()};
}

TEST(BadInput, AMisspeltConfigKeyNamesFileAndLine) {
  const TemporaryFolder folder;
  const fs::path config = folder.path() / "robot.yaml";
  std::ofstream(config) << "mapper:\n  resolutoin_m: 0.01\n";
  const Ran ran = run(folder, {program("cairn-mapper"), "--config", config, "--check"});
  EXPECT_EQ(ran.code, 2);
  EXPECT_EQ(
      ran.output,
      config.string() + ":2: mapper.resolutoin_m: unknown key (did you mean 'resolution_m'?)\n");
}

TEST(BadInput, AWrongFlagIsAUsageError) {
  const TemporaryFolder folder;
  for (const char* name : {"cairn-camera", "cairn-stereo", "cairn-odometry", "cairn-localizer",
                           "cairn-mapper", "cairn-cli", "cairn-spy"}) {
    EXPECT_EQ(run(folder, {program(name), "--no-such-flag"}).code, 2) << name;
    EXPECT_EQ(run(folder, {program(name), "--help"}).code, 0) << name;
    EXPECT_EQ(run(folder, {program(name), "--version"}).code, 0) << name;
  }
}

TEST(BadInput, AMissingSourceIsNamed) {
  const TemporaryFolder folder;
  const Ran ran = run(folder, {program("cairn-cli"), "replay", "/nowhere/street", "--lockstep",
                               "--out", folder.path() / "out"});
  EXPECT_EQ(ran.code, 1);
  EXPECT_EQ(ran.output, "/nowhere/street: no such file or folder\n");
}

/// A copy of the first frames of the rendered room, to be damaged.
fs::path small_dataset(const TemporaryFolder& folder) {
  const fs::path copy = folder.path() / "dataset";
  for (const char* side : {"left", "right"}) {
    fs::create_directories(copy / side);
    for (int i = 0; i < 12; ++i) {
      const std::string name = "0000" + std::string(i < 10 ? "0" : "") + std::to_string(i) + ".png";
      fs::copy(rendered_room() / side / name, copy / side / name);
    }
  }
  fs::copy(rendered_room() / "dataset.yaml", copy / "dataset.yaml");
  fs::copy(rendered_room() / "truth.txt", copy / "truth.txt");
  return copy;
}

TEST(BadInput, AFolderWithOtherFilesIsNotWrittenInto) {
  const TemporaryFolder folder;
  const fs::path out = folder.path() / "thesis";
  fs::create_directories(out);
  std::ofstream(out / "thesis.tex") << "years of work";
  const Ran ran =
      run(folder, {program("cairn-cli"), "replay", rendered_room(), "--lockstep", "--out", out});
  EXPECT_EQ(ran.code, 1);
  EXPECT_NE(ran.output.find("no run of cairn wrote"), std::string::npos) << ran.output;
  EXPECT_TRUE(fs::exists(out / "thesis.tex"));
}

TEST(BadInput, NothingOfAnEarlierRunIsLostToAWrongCommandLine) {
  const TemporaryFolder folder;
  const fs::path out = folder.path() / "out";
  const fs::path dataset = small_dataset(folder);
  ASSERT_EQ(run(folder, {program("cairn-cli"), "replay", dataset, "--lockstep", "--out", out}).code,
            0);
  const std::vector<std::vector<std::string>> wrong{
      {"--set", "mapper.resoluton_m=0.1"}, {"--set", "mapper.resolution_m=9"},
      {"--set", "resolution_m=0.1"},       {"--map", out / "map.cairn"},
      {"--truth", out / "truth.tum"},      {"--map", "README.md"}};
  for (const std::vector<std::string>& words : wrong) {
    std::vector<std::string> command{program("cairn-cli"), "replay", dataset,
                                     "--lockstep",         "--out",  out};
    command.insert(command.end(), words.begin(), words.end());
    EXPECT_NE(run(folder, command).code, 0) << words.back();
    EXPECT_TRUE(fs::exists(out / "map.cairn")) << words.back();
    EXPECT_TRUE(fs::exists(out / "report.json")) << words.back();
  }
}

TEST(BadInput, TwoGroupsOnOnePortAreNotMixed) {
  if (!enter_network_namespace() || !add_multicast_route()) GTEST_SKIP() << kNoNamespace;
  LiveGroup group(rendered_room());
  group.start("stereo");
  ASSERT_TRUE(group.listen_until_heard({"stereo"}));
  const TemporaryFolder folder;
  const Ran ran = run(folder, {program("cairn-cli"), "replay", rendered_room(), "--lcm-url",
                               kStockUrl, "--out", folder.path() / "out"});
  group.stop();
  EXPECT_EQ(ran.code, 1);
  EXPECT_NE(ran.output.find("another group's stereo is on this bus already"), std::string::npos)
      << ran.output;
}

TEST(BadInput, ADatasetWithAnImageMissingNamesIt) {
  const TemporaryFolder folder;
  const fs::path dataset = small_dataset(folder);
  fs::remove(dataset / "right/000005.png");
  const Ran ran = run(folder, {program("cairn-cli"), "replay", dataset, "--lockstep", "--out",
                               folder.path() / "out"});
  EXPECT_EQ(ran.code, 1);
  EXPECT_NE(ran.output.find("000005.png"), std::string::npos) << ran.output;
}

TEST(BadInput, AnImageOfAnotherSizeIsRefusedAndTheOthersAreUsed) {
  const TemporaryFolder folder;
  const fs::path dataset = small_dataset(folder);
  // A 1 x 1 grey PNG.
  const std::vector<std::uint8_t> tiny{
      0x89, 'P',  'N',  'G',  0x0d, 0x0a, 0x1a, 0x0a, 0,    0,    0,    0x0d, 'I',  'H',
      'D',  'R',  0,    0,    0,    1,    0,    0,    0,    1,    8,    0,    0,    0,
      0,    0x3a, 0x7e, 0x9b, 0x55, 0,    0,    0,    0x0a, 'I',  'D',  'A',  'T',  0x78,
      0x9c, 0x63, 0x60, 0,    0,    0,    2,    0,    1,    0x48, 0xaf, 0xa4, 0x71, 0,
      0,    0,    0,    'I',  'E',  'N',  'D',  0xae, 0x42, 0x60, 0x82};
  ASSERT_TRUE(write_file_atomically(dataset / "left/000007.png", tiny));
  const Ran ran = run(folder, {program("cairn-cli"), "replay", dataset, "--lockstep", "--out",
                               folder.path() / "out"});
  EXPECT_EQ(ran.code, 0);
  EXPECT_NE(ran.output.find("000007.png"), std::string::npos) << ran.output;
  EXPECT_NE(ran.output.find("11 frames"), std::string::npos) << ran.output;
}

TEST(BadInput, ADamagedRecordingIsPlayedButForItsDamage) {
  const TemporaryFolder folder;
  const fs::path out = folder.path() / "out";
  ASSERT_EQ(run(folder,
                {program("cairn-cli"), "replay", small_dataset(folder), "--lockstep", "--out", out})
                .code,
            0);
  const auto whole = read_file(out / "recording.lcmlog").value();
  std::mt19937 random(11);
  for (int trial = 0; trial < 6; ++trial) {
    auto damaged = whole;
    if (trial % 2 == 0) {
      damaged.resize(damaged.size() / 2 + random() % (damaged.size() / 2));
    } else {
      for (int flips = 0; flips < 20; ++flips) damaged[random() % damaged.size()] ^= 0x10;
    }
    const fs::path log = folder.path() / "damaged.lcmlog";
    ASSERT_TRUE(write_file_atomically(log, damaged));
    const Ran ran = run(folder, {program("cairn-cli"), "replay", log, "--lockstep", "--out",
                                 folder.path() / "again"});
    EXPECT_EQ(ran.code, 0) << ran.output;
    EXPECT_NE(ran.output.find("frames; the recording is at its end"), std::string::npos)
        << ran.output;
  }
  ASSERT_TRUE(
      write_file_atomically(folder.path() / "junk.lcmlog", std::vector<std::uint8_t>(5000, 'j')));
  const Ran ran = run(folder, {program("cairn-cli"), "replay", folder.path() / "junk.lcmlog",
                               "--lockstep", "--out", folder.path() / "again"});
  EXPECT_EQ(ran.code, 1);
  EXPECT_NE(ran.output.find("is it a recording?"), std::string::npos) << ran.output;
}

TEST(BadInput, WithoutARouteEveryProcessSaysWhatMendsIt) {
  if (!enter_network_namespace()) GTEST_SKIP() << kNoNamespace;
  const TemporaryFolder folder;
  for (const char* name : {"cairn-stereo", "cairn-odometry", "cairn-localizer", "cairn-mapper"}) {
    const Ran ran = run(folder, {program(name)});
    EXPECT_EQ(ran.code, 1) << name;
    EXPECT_NE(ran.output.find("sudo ip route add 224.0.0.0/4 dev lo"), std::string::npos)
        << ran.output;
  }
}

TEST(BadInput, ATakenPortIsNamed) {
  if (!enter_network_namespace() || !add_multicast_route()) GTEST_SKIP() << kNoNamespace;
  const TemporaryFolder folder;
  const int holder = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  sockaddr_in any{};
  any.sin_family = AF_INET;
  any.sin_port = htons(7667);
  ASSERT_EQ(::bind(holder, reinterpret_cast<const sockaddr*>(&any), sizeof(any)), 0);
  const Ran ran = run(folder, {program("cairn-stereo")});
  ::close(holder);
  EXPECT_EQ(ran.code, 1);
  EXPECT_NE(ran.output.find("cannot listen on port 7667"), std::string::npos) << ran.output;
}

// H-BUS-3: junk thrown at a live group.
TEST(BadInput, TenThousandJunkDatagramsLeaveTheLiveGroupWhole) {
  if (!enter_network_namespace() || !add_multicast_route()) GTEST_SKIP() << kNoNamespace;
  LiveGroup group(rendered_room(), 0.5);
  for (const std::string& process : kWithoutCamera) group.start(process);
  ASSERT_TRUE(group.listen_until_heard(kWithoutCamera));
  group.start("camera");
  ASSERT_TRUE(group.listen_until([&] { return group.heard().frames() > 3; }));
  std::mt19937 random(12);
  constexpr const char* kTargets[] = {"STEREO_FRAME", "DISPARITY", "ODOMETRY",
                                      "CALIBRATION",  "CLOCK",     "MAP_COMMAND"};
  for (int i = 0; i < 10'000; ++i) {
    std::vector<std::uint8_t> junk(8 + random() % 300);
    for (std::uint8_t& byte : junk) byte = static_cast<std::uint8_t>(random());
    ASSERT_TRUE(group.bus().publish(kTargets[i % 6], junk));
    if (i % 20 == 0) group.node().spin_once(1000);
  }
  EXPECT_EQ(group.wait("camera"), 0);
  group.listen_until_quiet();
  group.stop();
  EXPECT_EQ(group.heard().trajectory().size(), 60U) << "every frame has its pose all the same";
  EXPECT_GT(group.heard().refused()["STEREO_FRAME"], 0U);
  EXPECT_GT(group.heard().refused()["DISPARITY"], 0U);
  for (const auto& [process, restarts] : group.heard().restarts())
    EXPECT_EQ(restarts, 0U) << process;
}

}  // namespace
}  // namespace cairn::testing
