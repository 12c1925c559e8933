// SPDX-License-Identifier: Apache-2.0
#include "supervisor/processes_of_run.hpp"

#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <fstream>
#include <sstream>

namespace cairn::testing {
namespace {

namespace fs = std::filesystem;

std::string command_line(const fs::path& process) {
  std::ifstream file(process / "cmdline", std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  std::string line = text.str();
  std::replace(line.begin(), line.end(), '\0', ' ');
  return line;
}

}  // namespace

std::multiset<pid_t> processes_with(const std::string& text) {
  std::multiset<pid_t> pids;
  for (const auto& entry : fs::directory_iterator("/proc")) {
    const std::string name = entry.path().filename();
    if (name.find_first_not_of("0123456789") != std::string::npos) continue;
    if (command_line(entry.path()).find(text) != std::string::npos) pids.insert(std::stoi(name));
  }
  pids.erase(::getpid());
  return pids;
}

void kill_processes_of(const fs::path& run) {
  for (int tries = 0; tries < 500; ++tries) {
    const auto pids = processes_of(run);
    if (pids.empty()) return;
    for (const pid_t pid : pids) ::kill(pid, SIGKILL);
    ::poll(nullptr, 0, 10);
    while (::waitpid(-1, nullptr, WNOHANG) > 0) {
    }
  }
}

}  // namespace cairn::testing
