// SPDX-License-Identifier: Apache-2.0
#include "procs/cli/run_plan.hpp"

#include <algorithm>

#include "bus/process.hpp"
#include "camera/frame_source.hpp"

namespace cairn::cli {
namespace {

Result<void> check_settings(const RunPlan& plan) {
  for (const std::string& setting : plan.settings) {
    const std::string process = setting.substr(0, setting.find('.'));
    if (std::find(bus::kProcesses.begin(), bus::kProcesses.end(), process) ==
        bus::kProcesses.end()) {
      return fail(
          "--set " + setting + ": '" + process +
          "' is no process (form: PROCESS.KEY=VALUE; processes: camera, stereo, odometry, mapper)");
    }
  }
  return {};
}

}  // namespace

Result<RunPlan> complete(RunPlan plan) {
  if (auto checked = check_settings(plan); !checked) return tl::make_unexpected(checked.error());
  std::error_code error;
  if (!std::filesystem::exists(plan.source, error))
    return fail(plan.source.string() + ": no such file or folder");
  plan.source_is_dataset = std::filesystem::is_directory(plan.source, error);
  if (plan.source_is_dataset) {
    const auto dataset = camera::open_dataset(plan.source.string());
    if (!dataset) return tl::make_unexpected(dataset.error());
    if (plan.truth.empty()) {
      plan.truth = dataset->info.truth_file;
      plan.truth_format = dataset->info.truth_format;
      plan.truth_frame = dataset->info.truth_frame;
    }
    plan.map_resolution_m = dataset->info.map_resolution_m;
    plan.map_max_range_m = dataset->info.map_max_range_m;
  }
  if (plan.truth_poses && plan.truth.empty())
    return fail("--poses truth: the source names no truth; give --truth FILE");
  return plan;
}

ConfigSource config_of(const RunPlan& plan, const std::string& process) {
  ConfigSource source{plan.config_file, {}};
  if (process == "camera") {
    source.overrides = {"source=dataset", "dataset=" + plan.source.string(),
                        "speed=" + std::to_string(plan.speed)};
  }
  if (process == "mapper") {
    source.overrides.push_back(plan.truth_poses ? "pose=POSE" : "pose=ODOMETRY");
    if (!plan.map.empty()) source.overrides.push_back("map=" + plan.map.string());
    if (plan.map_resolution_m > 0) {
      source.overrides.push_back("resolution_m=" + std::to_string(plan.map_resolution_m));
    }
    if (plan.map_max_range_m > 0) {
      source.overrides.push_back("rays.max_range_m=" + std::to_string(plan.map_max_range_m));
    }
  }
  for (const std::string& setting : plan.settings) {
    if (setting.starts_with(process + "."))
      source.overrides.push_back(setting.substr(process.size() + 1));
  }
  return source;
}

std::filesystem::path state_of(const RunPlan& plan, const std::string& process) {
  return plan.out / "state" / process;
}

}  // namespace cairn::cli
