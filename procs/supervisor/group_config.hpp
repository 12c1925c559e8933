// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/config.hpp"
#include "core/result.hpp"

namespace cairn {

/// One process of a group: what is started, with what, and what becomes of it when it ends.
struct GroupProcess {
  std::string name;
  std::string program;
  std::vector<std::string> settings;
  std::vector<std::string> after;
  std::string restart = "always";
  bool at_start = true;
  double stop_grace_s = 10;

  void visit(ConfigVisitor& v);
};

/// A group of processes: what a file in config/groups says.
struct GroupConfig {
  std::string group;
  std::string robot;
  std::string lcm_url;
  std::vector<GroupProcess> processes;

  void visit(ConfigVisitor& v);

  /// Nothing if the group has none of this name.
  [[nodiscard]] GroupProcess* find(const std::string& process);
};

/// Strictly; an error names file and line. `robot` and each `program` come back as absolute paths
/// of files that are there, `${HERE}` in settings as the file's folder, `group` as the file itself
/// where it does not name another.
[[nodiscard]] Result<GroupConfig> load_group(const std::filesystem::path& file);

/// What load_group takes back.
[[nodiscard]] std::string print_group(GroupConfig group);

/// The words that start the process in this run: program, bus, state folder, robot file, settings.
/// In settings `${RUN}` stands for the run's folder.
[[nodiscard]] std::vector<std::string> command_of(const GroupConfig& group,
                                                  const GroupProcess& process,
                                                  const std::filesystem::path& run);

}  // namespace cairn
