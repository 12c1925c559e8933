// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/config.hpp"
#include "core/result.hpp"

namespace cairn::cli {

/// What `cairn replay` and `cairn demo` run: one recording through the process group.
struct RunPlan {
  std::filesystem::path source;  ///< a dataset folder or an LCM recording
  bool source_is_dataset = false;
  std::filesystem::path config_file;  ///< of all processes; empty: defaults
  std::vector<std::string> settings;  ///< "process.key=value", win over all else
  std::filesystem::path map;          ///< map to begin with; empty: none
  std::filesystem::path out;          ///< where results go
  std::filesystem::path truth;        ///< empty: what the dataset names, if it does
  std::string truth_format;
  std::string truth_frame;   ///< left_camera or body
  bool truth_poses = false;  ///< the mapper takes its poses from the truth
  double speed = 1;
  int threads = 1;
  bool record_all = false;
  std::string lcm_url;
  double map_resolution_m = 0;  ///< what the dataset says; 0: nothing
  double map_max_range_m = 0;
};

/// Whether every process would take its config: the error says which key of which file or setting
/// is wrong.
[[nodiscard]] Result<void> check_config(const RunPlan& plan);

/// Fills in what the source says about itself, and looks at all that the run is to read. An error
/// names what is missing.
[[nodiscard]] Result<RunPlan> complete(RunPlan plan);

/// Where this process's config comes from under the plan.
[[nodiscard]] ConfigSource config_of(const RunPlan& plan, const std::string& process);

/// The state folder of a process of this run.
[[nodiscard]] std::filesystem::path state_of(const RunPlan& plan, const std::string& process);

}  // namespace cairn::cli
