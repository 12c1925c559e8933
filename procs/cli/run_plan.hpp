// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/config.hpp"
#include "core/result.hpp"

namespace cairn::cli {

/// What `cairn replay` and `cairn demo` run: a process group on a recording, or on a simulated
/// place.
struct RunPlan {
  std::filesystem::path source;  ///< a dataset folder or an LCM recording; empty: simulated
  bool source_is_dataset = false;
  std::filesystem::path config_file;  ///< of all processes; empty: defaults
  std::vector<std::string> implied;   ///< "process.key=value": what other options come to
  std::vector<std::string> settings;  ///< the same as given by hand; win over all else
  std::filesystem::path map;          ///< map to begin with; empty: none
  std::filesystem::path out;          ///< where results go
  std::filesystem::path truth;        ///< empty: what the dataset names, if it does
  std::string truth_format;
  std::string truth_frame;   ///< left_camera or body
  bool truth_poses = false;  ///< the mapper takes its poses from the truth
  bool localizer = true;     ///< runs; else the mapper maps along odometry, or the truth
  double speed = 1;
  int threads = 1;
  bool record_all = false;
  std::string lcm_url;
};

/// Whether every process would take its config: the error says which key of which file or setting
/// is wrong.
[[nodiscard]] Result<void> check_config(const RunPlan& plan);

/// Fills in what the source says about itself, and looks at all that the run is to read. A
/// recording that lies in the folder of the run that made it, is run with that run's config where
/// the plan names none. An error names what is missing.
[[nodiscard]] Result<RunPlan> complete(RunPlan plan);

/// Where this process's config comes from under the plan.
[[nodiscard]] ConfigSource config_of(const RunPlan& plan, const std::string& process);

/// The effective config of all processes, as a file that --config takes.
[[nodiscard]] Result<std::string> config_text(const RunPlan& plan);

/// The state folder of a process of this run.
[[nodiscard]] std::filesystem::path state_of(const RunPlan& plan, const std::string& process);

}  // namespace cairn::cli
