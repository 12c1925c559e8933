// SPDX-License-Identifier: Apache-2.0
#include "procs/cli/run_plan.hpp"

#include <algorithm>

#include "bus/process.hpp"
#include "bus/recording.hpp"
#include "camera/frame_source.hpp"
#include "mapping/map_file.hpp"
#include "procs/cli/run_folder.hpp"
#include "procs/cli/run_processes.hpp"
#include "procs/cli/truth.hpp"

namespace cairn::cli {
namespace {

Result<void> check_settings(const RunPlan& plan) {
  for (const std::string& setting : plan.settings) {
    const std::string key = setting.substr(0, setting.find('='));
    const std::size_t dot = key.find('.');
    const std::string process = key.substr(0, dot);
    if (dot == std::string::npos || std::find(bus::kProcesses.begin(), bus::kProcesses.end(),
                                              process) == bus::kProcesses.end()) {
      return fail("--set " + setting +
                  ": must begin with a process (stereo, odometry, localizer, mapper ...): --set " +
                  "mapper.resolution_m=0.05");
    }
  }
  return {};
}

template <class Config>
Result<Config> load(const RunPlan& plan, const char* process) {
  return load_config<Config>(config_of(plan, process), process, bus::kConfigSections);
}

Result<void> take_from_dataset(RunPlan& plan) {
  const auto dataset = camera::open_dataset(plan.source.string());
  if (!dataset) return tl::make_unexpected(dataset.error());
  if (plan.truth.empty()) {
    plan.truth = dataset->info.truth_file;
    plan.truth_format = dataset->info.truth_format;
    plan.truth_frame = dataset->info.truth_frame;
  }
  if (dataset->frames->is_depth() && !plan.truth_poses) {
    return fail(
        plan.source.string() +
        ": a depth recording has no images to take odometry from; use --lockstep --poses truth");
  }
  plan.implied.push_back("camera.source=dataset");
  plan.implied.push_back("camera.dataset=" + plan.source.string());
  plan.implied.push_back("camera.speed=" + std::to_string(plan.speed));
  if (dataset->info.map_resolution_m > 0) {
    plan.implied.push_back("mapper.resolution_m=" + std::to_string(dataset->info.map_resolution_m));
  }
  if (dataset->info.map_max_range_m > 0) {
    plan.implied.push_back("mapper.rays.max_range_m=" +
                           std::to_string(dataset->info.map_max_range_m));
  }
  return {};
}

Result<void> check_inputs(const RunPlan& plan) {
  if (!plan.source_is_dataset) {
    if (auto reader = bus::RecordingReader::open(plan.source); !reader)
      return tl::make_unexpected(reader.error());
  }
  if (!plan.map.empty()) {
    if (auto map = mapping::load_map(plan.map, {}); !map) return tl::make_unexpected(map.error());
  }
  if (!plan.truth.empty()) {
    if (auto format = guess_format(plan.truth); !format) return tl::make_unexpected(format.error());
  }
  return {};
}

}  // namespace

Result<void> check_config(const RunPlan& plan) {
  if (auto checked = check_settings(plan); !checked) return checked;
  return for_each_process([&]<class ProcessNode>() -> Result<void> {
    const auto config = load<typename ProcessNode::Config>(plan, ProcessNode::kName);
    if (!config) return tl::make_unexpected(config.error());
    if (std::is_same_v<ProcessNode, SimulatorNode> && !plan.source.empty()) return {};
    if constexpr (requires { ProcessNode::check(*config); }) return ProcessNode::check(*config);
    return {};
  });
}

Result<RunPlan> complete(RunPlan plan) {
  std::error_code error;
  if (!std::filesystem::exists(plan.source, error))
    return fail(plan.source.string() + ": no such file or folder");
  plan.source_is_dataset = std::filesystem::is_directory(plan.source, error);
  if (plan.source_is_dataset) {
    if (auto taken = take_from_dataset(plan); !taken) return tl::make_unexpected(taken.error());
  } else if (plan.config_file.empty()) {
    plan.config_file = config_of_run(plan.source.parent_path());
  }
  if (plan.truth_poses && plan.truth.empty())
    return fail("--poses truth: the source names no truth; give --truth FILE");
  const auto mapper = load<MapperConfig>(plan, MapperNode::kName);
  if (!mapper) return tl::make_unexpected(mapper.error());
  plan.localizer = mapper->pose == "POSE" && !plan.truth_poses;
  if (auto checked = check_inputs(plan); !checked) return tl::make_unexpected(checked.error());
  return plan;
}

ConfigSource config_of(const RunPlan& plan, const std::string& process) {
  ConfigSource source{plan.config_file, {}};
  for (const auto* settings : {&plan.implied, &plan.settings}) {
    for (const std::string& setting : *settings) {
      if (setting.starts_with(process + "."))
        source.overrides.push_back(setting.substr(process.size() + 1));
    }
  }
  return source;
}

Result<std::string> config_text(const RunPlan& plan) {
  std::string text;
  auto printed = for_each_process([&]<class ProcessNode>() -> Result<void> {
    auto config = load<typename ProcessNode::Config>(plan, ProcessNode::kName);
    if (!config) return tl::make_unexpected(config.error());
    text +=
        print_config(ProcessNode::kName, [&](ConfigVisitor& visitor) { config->visit(visitor); });
    return {};
  });
  if (!printed) return tl::make_unexpected(printed.error());
  return text;
}

std::filesystem::path state_of(const RunPlan& plan, const std::string& process) {
  return plan.out / "state" / process;
}

}  // namespace cairn::cli
