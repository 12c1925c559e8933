// SPDX-License-Identifier: Apache-2.0
#include "procs/cli/group_plan.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <ctime>
#include <fstream>
#include <sstream>

#include "bus/bus.hpp"
#include "core/atomic_file.hpp"
#include "core/child_process.hpp"
#include "mapping/map_file.hpp"

namespace cairn::cli {
namespace {

namespace fs = std::filesystem;

Result<fs::path> absolute_file(const fs::path& file) {
  std::error_code error;
  if (!fs::exists(file, error)) return fail(file.string() + ": no such file");
  return fs::weakly_canonical(fs::absolute(file));
}

std::string names_of(const GroupConfig& group) {
  std::string names;
  for (const GroupProcess& process : group.processes) {
    names += (names.empty() ? "" : ", ") + process.name;
  }
  return names;
}

Result<void> add_setting(GroupConfig& group, const std::string& setting) {
  const std::size_t dot = setting.find('.');
  const std::size_t equals = setting.find('=');
  GroupProcess* process =
      dot < equals && equals != std::string::npos ? group.find(setting.substr(0, dot)) : nullptr;
  if (process == nullptr) {
    return fail("--set " + setting + ": must be PROCESS.KEY=VALUE, PROCESS one of " +
                names_of(group));
  }
  process->settings.push_back(setting.substr(dot + 1));
  return {};
}

Result<void> begin_with_map(GroupConfig& group, const GroupPlan& plan) {
  if (plan.localize_only && plan.map.empty()) {
    return fail("--localize-only: needs a map to find itself in: --map FILE");
  }
  if (plan.map.empty()) return {};
  const auto map = absolute_file(plan.map);
  if (!map) return tl::make_unexpected(map.error());
  if (auto loaded = mapping::load_map(*map, {}); !loaded) {
    return tl::make_unexpected(loaded.error());
  }
  if (auto added = add_setting(group, "mapper.map=" + map->string()); !added) return added;
  return plan.localize_only ? add_setting(group, "mapper.integrate=false") : Result<void>{};
}

std::string text_of(const fs::path& file) {
  std::ifstream stream(file);
  std::ostringstream text;
  text << stream.rdbuf();
  return text.str();
}

std::string date_and_time() {
  const std::time_t now = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
  std::tm local{};
  ::localtime_r(&now, &local);
  std::array<char, 32> text{};
  const std::size_t size = std::strftime(text.data(), text.size(), "%Y%m%d-%H%M%S", &local);
  return {text.data(), size};
}

}  // namespace

Result<GroupConfig> make_group(const GroupPlan& plan) {
  auto group = load_group(plan.group);
  if (!group) return group;
  if (!plan.robot.empty()) {
    const auto robot = absolute_file(plan.robot);
    if (!robot) return tl::make_unexpected(robot.error());
    group->robot = *robot;
  }
  if (auto begun = begin_with_map(*group, plan); !begun) return tl::make_unexpected(begun.error());
  for (const std::string& setting : plan.settings) {
    if (auto added = add_setting(*group, setting); !added) {
      return tl::make_unexpected(added.error());
    }
  }
  for (const std::string& name : plan.without) {
    GroupProcess* process = group->find(name);
    if (process == nullptr) {
      return fail("--without " + name + ": the group has " + names_of(*group));
    }
    process->at_start = false;
  }
  group->lcm_url = bus::effective_url(plan.lcm_url.empty() ? group->lcm_url : plan.lcm_url);
  return group;
}

Result<void> check_processes(const GroupConfig& group, const fs::path& run) {
  struct Check {
    ChildProcess process;
    fs::path output;
  };
  std::string template_name = (fs::temp_directory_path() / "cairn-check-XXXXXX").string();
  if (::mkdtemp(template_name.data()) == nullptr) {
    return fail(template_name + ": cannot be made: " + std::strerror(errno));
  }
  const fs::path folder = template_name;
  Result<void> result;
  std::vector<Check> checks;
  for (const GroupProcess& process : group.processes) {
    if (!process.program.empty()) continue;
    auto command = command_of(group, process, run);
    command.push_back("--check");
    const fs::path output = folder / process.name;
    auto started = ChildProcess::start(command, output);
    if (!started) {
      result = tl::make_unexpected(started.error());
      break;
    }
    checks.push_back({std::move(*started), output});
  }
  std::string errors;
  for (Check& check : checks) {
    if (check.process.wait() != 0) errors += text_of(check.output);
  }
  std::error_code ignored;
  fs::remove_all(folder, ignored);
  if (!result) return result;
  while (errors.ends_with('\n')) errors.pop_back();
  return errors.empty() ? Result<void>{} : fail(errors);
}

Result<void> write_group(const GroupConfig& group, const fs::path& run) {
  std::error_code error;
  fs::create_directories(run, error);
  if (error) return fail(run.string() + ": cannot make the folder: " + error.message());
  const std::string text = "# The group as this run has it.\n" + print_group(group);
  return write_file_atomically(run / "group.yaml",
                               {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
}

Result<fs::path> make_run_folder() {
  std::error_code error;
  fs::create_directories("logs", error);
  std::string name = fs::absolute("logs/run-" + date_and_time() + "-XXXXXX").string();
  if (::mkdtemp(name.data()) == nullptr) {
    return fail(name + ": cannot be made: " + std::strerror(errno));
  }
  fs::permissions(name, fs::perms(0755), error);
  return fs::path(name);
}

}  // namespace cairn::cli
