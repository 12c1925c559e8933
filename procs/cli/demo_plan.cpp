// SPDX-License-Identifier: Apache-2.0
#include "procs/cli/demo_plan.hpp"

#include <filesystem>

#include "bus/process.hpp"
#include "mapping/map_file.hpp"
#include "procs/cli/shared_files.hpp"
#include "procs/stereo/stereo_node.hpp"

namespace cairn::cli {
namespace {

namespace fs = std::filesystem;

constexpr const char* kWorld = "config/worlds/room.yaml";
constexpr const char* kRobot = "config/robots/simulated.yaml";
constexpr const char* kFastRobot = "config/robots/simulated-fast.yaml";

}  // namespace

DemoPlan with_settings(DemoPlan plan) {
  const fs::path world = plan.world.empty() ? shared_file(kWorld) : fs::path(plan.world);
  const auto imply = [&](const std::string& setting) { plan.run.implied.push_back(setting); };
  imply("simulator.world=" + fs::absolute(world).string());
  imply("simulator.seed=" + std::to_string(plan.seed));
  imply("simulator.people=" + std::to_string(plan.people));
  imply("simulator.speed=" + std::to_string(plan.run.speed));
  imply(std::string("simulator.fast=") + (plan.fast ? "true" : "false"));
  if (!plan.run.map.empty()) imply("mapper.map=" + fs::absolute(plan.run.map).string());
  if (plan.run.config_file.empty())
    plan.run.config_file = shared_file(plan.fast ? kFastRobot : kRobot);
  plan.run.config_file = fs::absolute(plan.run.config_file);
  plan.run.out = fs::absolute(plan.run.out);
  return plan;
}

Result<DemoPlan> complete(DemoPlan plan) {
  const auto simulator = load_config<SimulatorConfig>(config_of(plan.run, "simulator"), "simulator",
                                                      bus::kConfigSections);
  if (!simulator) return tl::make_unexpected(simulator.error());
  plan.simulator = *simulator;
  // A rig that ships is named as from the project's folder, wherever this is run.
  if (!fs::exists(plan.simulator.rig)) {
    plan.simulator.rig = shared_file(plan.simulator.rig);
    plan.run.settings.push_back("simulator.rig=" + plan.simulator.rig);
  }
  const auto stereo = load_config<StereoNode::Config>(config_of(plan.run, StereoNode::kName),
                                                      StereoNode::kName, bus::kConfigSections);
  if (!stereo) return tl::make_unexpected(stereo.error());
  plan.max_disparity_px = stereo->max_disparity_px;
  if (!plan.run.map.empty()) {
    if (auto map = mapping::load_map(plan.run.map, {}); !map)
      return tl::make_unexpected(map.error());
  }
  return plan;
}

}  // namespace cairn::cli
