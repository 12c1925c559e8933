// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/result.hpp"
#include "procs/supervisor/group_config.hpp"

namespace cairn::cli {

/// How a group is to be run: a shipped or own group file, and what differs from it in this run.
struct GroupPlan {
  std::filesystem::path group;        ///< file
  std::filesystem::path run;          ///< folder of its state and logs
  std::vector<std::string> settings;  ///< "PROCESS.KEY=VALUE"; win over the group's
  std::vector<std::string> without;   ///< processes that are not started with the others
  std::filesystem::path robot;        ///< in place of the group's robot file; empty: the group's
  std::filesystem::path map;          ///< the mapper begins with it; empty: with an empty one
  bool localize_only = false;         ///< the map does not change
  std::string lcm_url;                ///< empty: the group's, else as bus::effective_url("")
};

/// The group as this plan has it, all paths absolute. An error names what is wrong: a key of the
/// group file, a setting of a process that the group does not have, a missing map.
[[nodiscard]] Result<GroupConfig> make_group(const GroupPlan& plan);

/// Asks each of the project's processes whether it would take its config; an error is what they
/// find wrong with it, with file and line.
[[nodiscard]] Result<void> check_processes(const GroupConfig& group,
                                           const std::filesystem::path& run);

/// What a supervisor needs to know of a run, and what survives it: RUN/group.yaml. Makes the folder
/// if it is missing; nothing else of it is touched.
[[nodiscard]] Result<void> write_group(const GroupConfig& group, const std::filesystem::path& run);

/// logs/run-DATE-XXXXXX: new, whoever else makes one at the same moment.
[[nodiscard]] Result<std::filesystem::path> make_run_folder();

}  // namespace cairn::cli
