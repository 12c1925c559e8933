// SPDX-License-Identifier: Apache-2.0
#include "procs/supervisor/group_config.hpp"

#include <algorithm>
#include <string_view>

#include "bus/process.hpp"
#include "core/start_program.hpp"

namespace cairn {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kRun = "${RUN}";
constexpr std::string_view kHere = "${HERE}";

bool is_known(const std::string& process) {
  return std::find(bus::kProcesses.begin(), bus::kProcesses.end(), process) !=
         bus::kProcesses.end();
}

std::string known_processes() {
  std::string names;
  for (const std::string_view name : bus::kProcesses) {
    names += (names.empty() ? "" : ", ") + std::string(name);
  }
  return names;
}

// It becomes the name of a folder.
bool is_good_name(const std::string& name) {
  return !name.empty() && name.size() <= 30 && name != "supervisor" &&
         name.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789_-") == std::string::npos;
}

fs::path beside(const fs::path& file, const fs::path& named) {
  return fs::weakly_canonical(fs::absolute(file).parent_path() / named);
}

void check_file(ConfigVisitor& v, const char* key, const fs::path& file) {
  std::error_code error;
  if (!fs::exists(file, error)) v.reject(key, file.string() + ": no such file");
}

std::string replaced(std::string text, std::string_view word, const std::string& by) {
  for (std::size_t at = text.find(word); at != std::string::npos;
       at = text.find(word, at + by.size())) {
    text.replace(at, word.size(), by);
  }
  return text;
}

}  // namespace

void GroupProcess::visit(ConfigVisitor& v) {
  v.text("name", name, "of the process; unless it has a `program`, one of the project's");
  v.text(
      "program", program,
      "file that is started in place of cairn-NAME, with the same options; relative to this file");
  v.texts("settings", settings,
          "KEY=VALUE for the process; win over the robot file; ${RUN} is the run's folder, ${HERE} "
          "this file's");
  v.texts("after", after, "is started once these, which stand above it, are ready");
  v.choice("restart", restart, {"always", "on_failure", "never"},
           "what becomes of it when it ends; on_failure: not after it ended with code 0");
  v.flag("at_start", at_start, "is started with the group, not only by hand");
  v.number("stop_grace_s", stop_grace_s, {0.1, 600}, "s",
           "time to end after SIGINT; SIGTERM comes half-way, SIGKILL at the end");
  if (!is_good_name(name)) {
    v.reject("name", "'" + name + "' is no name (allowed: a-z 0-9 _ -, at most 30)");
  } else if (program.empty() && !is_known(name)) {
    v.reject("name", "'" + name + "' is none of the project's processes (allowed: " +
                         known_processes() + "; any other name with a program)");
  }
  for (const std::string& setting : settings) {
    if (setting.find('=') == std::string::npos || setting.front() == '=') {
      v.reject("settings", "'" + setting + "' is not of the form KEY=VALUE");
    }
  }
}

void GroupConfig::visit(ConfigVisitor& v) {
  v.text("group", group, "what the group is called; empty: this file");
  v.text("robot", robot,
         "config file of all its processes, relative to this file; empty: defaults");
  v.text("lcm_url", lcm_url, "bus of the group; empty: $LCM_DEFAULT_URL, else the default");
  v.list("processes", processes, "what runs");
  if (processes.empty()) v.reject("processes", "names no process");
  for (auto process = processes.begin(); process != processes.end(); ++process) {
    const auto stands_above = [&](const std::string& name) {
      return std::any_of(processes.begin(), process,
                         [&](const GroupProcess& other) { return other.name == name; });
    };
    if (stands_above(process->name)) {
      v.reject("processes", process->name + " stands here twice");
    }
    for (const std::string& name : process->after) {
      if (stands_above(name)) continue;
      v.reject("processes", process->name + ".after: " + name + " does not stand above it");
    }
  }
}

GroupProcess* GroupConfig::find(const std::string& process) {
  const auto found = std::find_if(processes.begin(), processes.end(),
                                  [&](const GroupProcess& one) { return one.name == process; });
  return found == processes.end() ? nullptr : &*found;
}

Result<GroupConfig> load_group(const fs::path& file) {
  GroupConfig group;
  auto loaded = load_config({file, {}}, "", {}, [&](ConfigVisitor& v) {
    group.visit(v);
    if (!group.robot.empty()) {
      group.robot = beside(file, group.robot);
      check_file(v, "robot", group.robot);
    }
    const std::string here = beside(file, ".").string();
    for (GroupProcess& process : group.processes) {
      for (std::string& setting : process.settings) setting = replaced(setting, kHere, here);
      if (process.program.empty()) continue;
      process.program = beside(file, process.program);
      check_file(v, "processes", process.program);
    }
  });
  if (!loaded) return tl::make_unexpected(loaded.error());
  if (group.group.empty()) group.group = fs::weakly_canonical(fs::absolute(file));
  return group;
}

std::string print_group(GroupConfig group) {
  return print_config("", [&](ConfigVisitor& v) { group.visit(v); });
}

std::vector<std::string> command_of(const GroupConfig& group, const GroupProcess& process,
                                    const fs::path& run) {
  std::vector<std::string> command{process.program.empty()
                                       ? (program_folder() / ("cairn-" + process.name)).string()
                                       : process.program,
                                   "--state", run / "state" / process.name};
  if (!group.lcm_url.empty()) command.insert(command.end(), {"--lcm-url", group.lcm_url});
  if (!group.robot.empty()) command.insert(command.end(), {"--config", group.robot});
  for (const std::string& setting : process.settings) {
    command.insert(command.end(), {"--set", replaced(setting, kRun, run.string())});
  }
  return command;
}

}  // namespace cairn
