// SPDX-License-Identifier: Apache-2.0
#include "procs/cli/run_plan.hpp"

#include <algorithm>

#include "bus/process.hpp"
#include "bus/recording.hpp"
#include "camera/frame_source.hpp"
#include "mapping/map_file.hpp"
#include "procs/camera/camera_node.hpp"
#include "procs/cli/truth.hpp"
#include "procs/mapper/mapper_node.hpp"
#include "procs/odometry/odometry_node.hpp"
#include "procs/stereo/stereo_node.hpp"

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
                  ": must begin with a process (camera, stereo, odometry, mapper): --set " +
                  "mapper.resolution_m=0.05");
    }
  }
  return {};
}

template <class Config>
Result<Config> load(const RunPlan& plan, const char* process) {
  return load_config<Config>(config_of(plan, process), process, bus::kConfigSections);
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
  if (auto camera = load<CameraConfig>(plan, "camera"); !camera)
    return tl::make_unexpected(camera.error());
  if (auto odometry = load<OdometryNode::Config>(plan, "odometry"); !odometry) {
    return tl::make_unexpected(odometry.error());
  }
  if (auto mapper = load<MapperConfig>(plan, "mapper"); !mapper)
    return tl::make_unexpected(mapper.error());
  const auto stereo = load<StereoNode::Config>(plan, "stereo");
  return stereo ? StereoNode::check(*stereo) : tl::make_unexpected(stereo.error());
}

Result<RunPlan> complete(RunPlan plan) {
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
    if (dataset->frames->is_depth() && !plan.truth_poses) {
      return fail(
          plan.source.string() +
          ": a depth recording has no images to take odometry from; use --lockstep --poses truth");
    }
    plan.map_resolution_m = dataset->info.map_resolution_m;
    plan.map_max_range_m = dataset->info.map_max_range_m;
  }
  if (plan.truth_poses && plan.truth.empty())
    return fail("--poses truth: the source names no truth; give --truth FILE");
  if (auto checked = check_inputs(plan); !checked) return tl::make_unexpected(checked.error());
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
