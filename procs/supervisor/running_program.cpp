// SPDX-License-Identifier: Apache-2.0
#include "procs/supervisor/running_program.hpp"

#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>
// It does not say so itself in glibc 2.36.
extern "C" {
#include <sys/pidfd.h>
}

#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <fstream>
#include <sstream>
#include <utility>

namespace cairn {
namespace {

std::string first_line(const std::string& file) {
  std::ifstream stream(file);
  std::string line;
  std::getline(stream, line);
  return line;
}

std::shared_ptr<const int> open_handle(pid_t pid) {
  const int fd = ::pidfd_open(pid, 0);
  if (fd < 0) return nullptr;
  return {new int(fd), [](const int* held) {
            ::close(*held);
            delete held;
          }};
}

}  // namespace

std::optional<ProgramStat> stat_of(pid_t pid) {
  // "pid (name) state ppid ..."; the name may hold anything. The 14th and 15th word are the time
  // used, the 22nd is the time of start.
  const std::string line = first_line("/proc/" + std::to_string(pid) + "/stat");
  const std::size_t name_end = line.rfind(')');
  if (name_end == std::string::npos) return std::nullopt;
  std::istringstream words(line.substr(name_end + 1));
  std::string state;
  words >> state;
  std::array<std::int64_t, 23> word{};
  for (std::size_t i = 4; i < word.size(); ++i) words >> word[i];
  if (!words || state == "Z" || state == "X") return std::nullopt;
  return ProgramStat{{pid, word[22]}, word[14] + word[15]};
}

std::optional<ProgramId> identify(pid_t pid) {
  const auto stat = stat_of(pid);
  return stat ? std::optional(stat->id) : std::nullopt;
}

bool in_session_of(pid_t pid, pid_t leader) { return pid == leader || ::getsid(pid) == leader; }

std::string boot_id() { return first_line("/proc/sys/kernel/random/boot_id"); }

Result<RunningProgram> RunningProgram::start(Program program,
                                             const std::function<Result<void>(ProgramId)>& note) {
  ProgramId id;
  std::shared_ptr<const int> handle;
  program.outlives_starter = true;
  program.note = [&](pid_t pid) -> Result<void> {
    const auto identified = identify(pid);
    handle = open_handle(pid);
    if (!identified || !handle) {
      return fail(program.command.front() + ": cannot be watched: " + std::strerror(errno));
    }
    id = *identified;
    return note(id);
  };
  const auto pid = start_program(program);
  if (!pid) return tl::make_unexpected(pid.error());
  return RunningProgram(id, std::move(handle), true);
}

std::optional<RunningProgram> RunningProgram::adopt(const ProgramId& id) {
  // First the handle, then the look: so the handle is of what was looked at.
  auto handle = id.pid > 0 ? open_handle(id.pid) : nullptr;
  if (!handle || identify(id.pid) != id) return std::nullopt;
  return RunningProgram(id, std::move(handle), false);
}

void RunningProgram::signal(int number) const {
  // It has no session of its own yet in the moment after its start.
  if (::kill(-id_.pid, number) != 0) ::pidfd_send_signal(*handle_, number, nullptr, 0);
}

std::optional<RunningProgram::End> RunningProgram::end() {
  pollfd readable{*handle_, POLLIN, 0};
  if (::poll(&readable, 1, 0) <= 0) return std::nullopt;
  // Its number is not given away before it is reaped, nor while something of its session is left.
  ::kill(-id_.pid, SIGKILL);
  int status = 0;
  if (!ours_ || ::waitpid(id_.pid, &status, 0) != id_.pid) return End{std::nullopt};
  return End{WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status)};
}

bool RunningProgram::owns(pid_t pid) const { return in_session_of(pid, id_.pid); }

}  // namespace cairn
