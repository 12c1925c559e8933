// SPDX-License-Identifier: Apache-2.0
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <iostream>
#include <memory>

#include "procs/cli/command.hpp"
#include "procs/cli/group_session.hpp"
#include "procs/cli/output_lines.hpp"
#include "procs/supervisor/running_program.hpp"

namespace cairn::cli {
namespace {

namespace fs = std::filesystem;

constexpr std::int64_t kTellAgain_us = 2 * kMicrosecondsPerSecond;
/// A supervisor gives its processes ten minutes at most.
constexpr std::int64_t kLongestDown_us = 620 * kMicrosecondsPerSecond;

std::string still_running(const GroupClient& group) {
  std::string names;
  if (group.state() == nullptr) return names;
  for (const process_state_t& process : group.state()->processes) {
    if (process.pid != 0) names += " " + process.process;
  }
  return names;
}

void show(const GroupClient& group) {
  if (::isatty(STDERR_FILENO) == 0) return;
  std::fprintf(stderr, "\r\033[Kending%s", still_running(group).c_str());
}

int down(const std::string& lcm_url) {
  const auto session = GroupSession::open(lcm_url);
  if (!session) return failed(session.error().message);
  if (auto found = (*session)->find_supervisor(); !found) return failed(found.error().message);
  GroupClient& group = (*session)->group();
  const fs::path run = group.state()->run;
  const auto supervisor = identify(group.state()->pid);
  const auto is_gone = [&] { return identify(supervisor ? supervisor->pid : 0) != supervisor; };
  if (!supervisor) return failed("the group's supervisor is not on this machine; end it there");
  const HostTime deadline_us = (*session)->node().host_time() + kLongestDown_us;
  while (!is_gone() && (*session)->node().host_time() < deadline_us) {
    group.tell(group_command_t::ACTION_END);
    group.wait_until(
        [&] {
          show(group);
          return is_gone();
        },
        kTellAgain_us);
  }
  if (::isatty(STDERR_FILENO) != 0) std::fprintf(stderr, "\r\033[K");
  if (!is_gone()) return failed("still running:" + still_running(group));
  const std::string left = still_running(group);
  if (!left.empty()) {
    const auto said = last_lines(run / "log" / "supervisor.log", 1);
    return failed(said.empty() ? "could not be ended:" + left : said.back());
  }
  const fs::path map = run / "state" / "mapper" / "map.cairn";
  std::error_code error;
  std::cout << "ended; run folder " << run.string() << "\n";
  if (fs::exists(map, error)) std::cout << "map: " << map.string() << "\n";
  return 0;
}

}  // namespace

void add_down(CLI::App& app, Run& run) {
  auto lcm_url = std::make_shared<std::string>();
  CLI::App* command = app.add_subcommand("down", "end the process group; the map is saved");
  command->add_option("--lcm-url", *lcm_url, "bus of the group");
  command->footer("Example:\n  cairn down");
  command->callback([&run, lcm_url] { run = [lcm_url] { return down(*lcm_url); }; });
}

}  // namespace cairn::cli
