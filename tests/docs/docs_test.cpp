// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "bus/channels.hpp"
#include "bus/process.hpp"
#include "core/config.hpp"
#include "procs/camera/camera_node.hpp"
#include "procs/mapper/mapper_node.hpp"
#include "procs/motor/motor_node.hpp"
#include "procs/odometry/odometry_node.hpp"
#include "procs/simulator/simulator_node.hpp"
#include "procs/stereo/stereo_node.hpp"
#include "procs/supervisor/supervisor_node.hpp"

namespace cairn {
namespace {

namespace fs = std::filesystem;

const fs::path kRoot = CAIRN_SOURCE_DIR;

std::string read(const fs::path& file) {
  std::ifstream stream(file);
  std::ostringstream text;
  text << stream.rdbuf();
  return text.str();
}

// The part of a page between its two marks must be `expected`.
void expect_part(const fs::path& page, const std::string& mark, const std::string& expected) {
  const std::string begin = "<!-- " + mark + " -->\n";
  const std::string end = "<!-- end of " + mark + " -->\n";
  std::string text = read(page);
  const std::size_t from = text.find(begin);
  const std::size_t to = text.find(end);
  ASSERT_TRUE(from != std::string::npos && to != std::string::npos && from < to)
      << page << " has no part " << mark;
  const std::size_t start = from + begin.size();
  if (std::getenv("CAIRN_WRITE_DOCS") != nullptr) {
    text.replace(start, to - start, expected);
    std::ofstream(page) << text;
    return;
  }
  EXPECT_EQ(text.substr(start, to - start), expected)
      << page << " is out of date; write it anew: CAIRN_WRITE_DOCS=1 ./cairn test -R Docs";
}

std::string backlog_text(bus::Backlog backlog) {
  if (backlog == bus::Backlog::kEvery) return "every one";
  return backlog == bus::Backlog::kNewest ? "newest wins"
                                          : "newest " + std::to_string(static_cast<int>(backlog));
}

TEST(Docs, TheChannelTableIsTheCatalogue) {
  std::string table =
      "| channel | type | from -> to | rate | what may wait |\n|---|---|---|---|---|\n";
  bus::for_each_channel([&](auto channel) {
    table += std::string("| ") + channel.name + " | `" + channel.type_name + "` | " + channel.flow +
             " | " + channel.rate + " | " + backlog_text(channel.backlog) + " |\n";
  });
  expect_part(kRoot / "ARCHITECTURE.md", "channels", table);
}

template <class Config>
std::string section(const std::string& process) {
  Config config;
  return "\n## " + process + "\n\n" +
         config_reference([&](ConfigVisitor& visitor) { config.visit(visitor); });
}

TEST(Docs, TheConfigReferenceIsTheCode) {
  expect_part(kRoot / "config" / "README.md", "reference",
              section<CameraConfig>("camera") + section<SimulatorConfig>("simulator") +
                  section<StereoNode::Config>("stereo") +
                  section<OdometryNode::Config>("odometry") + section<MapperConfig>("mapper") +
                  section<MotorConfig>("motor") + section<SupervisorConfig>("supervisor") + "\n");
}

template <class Config>
std::string reference() {
  Config config;
  return config_reference([&](ConfigVisitor& visitor) { config.visit(visitor); });
}

TEST(Docs, TheGroupReferenceIsTheCode) {
  const fs::path page = kRoot / "config" / "groups" / "README.md";
  expect_part(page, "group", reference<GroupConfig>());
  expect_part(page, "process", reference<GroupProcess>());
}

template <class Config>
void expect_loads(const fs::path& file, const char* process) {
  const auto loaded = load_config<Config>({file, {}}, process, bus::kConfigSections);
  EXPECT_TRUE(loaded) << loaded.error().message;
}

TEST(Docs, EveryShippedRobotLoads) {
  int files = 0;
  for (const auto& entry : fs::directory_iterator(kRoot / "config" / "robots")) {
    ++files;
    expect_loads<CameraConfig>(entry.path(), "camera");
    expect_loads<SimulatorConfig>(entry.path(), "simulator");
    expect_loads<StereoNode::Config>(entry.path(), "stereo");
    expect_loads<OdometryNode::Config>(entry.path(), "odometry");
    expect_loads<MapperConfig>(entry.path(), "mapper");
    expect_loads<MotorConfig>(entry.path(), "motor");
  }
  EXPECT_GE(files, 3);
}

TEST(Docs, EveryShippedRigLoads) {
  for (const auto& entry : fs::directory_iterator(kRoot / "config" / "calibration")) {
    if (entry.path().extension() != ".yaml") continue;
    const auto rig = camera::load_rig(entry.path().string());
    EXPECT_TRUE(rig) << rig.error().message;
  }
}

TEST(Docs, EveryProcessHasItsPage) {
  for (const auto& entry : fs::directory_iterator(kRoot / "procs")) {
    if (!entry.is_directory()) continue;
    EXPECT_TRUE(fs::exists(entry.path() / "README.md")) << entry.path();
  }
}

}  // namespace
}  // namespace cairn
