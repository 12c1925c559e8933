// SPDX-License-Identifier: Apache-2.0
#include "core/start_program.hpp"

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstring>

namespace cairn {
namespace {

/// What the new process needs, made before the fork: after it, only what is safe in a program with
/// threads may be called.
struct Prepared {
  std::vector<char*> arguments;
  std::vector<std::string> settings;
  std::vector<char*> environment;
  int output = -1;
  int gate_read = -1;
  int gate_write = -1;
  bool outlives_starter = false;
  pid_t starter = 0;
};

std::vector<char*> as_array(const std::vector<std::string>& words) {
  std::vector<char*> array;
  for (const std::string& word : words) array.push_back(const_cast<char*>(word.c_str()));
  array.push_back(nullptr);
  return array;
}

std::vector<std::string> merged_environment(const std::vector<std::string>& ours) {
  std::vector<std::string> merged = ours;
  const auto is_ours = [&](const std::string& entry) {
    const std::string key = entry.substr(0, entry.find('=') + 1);
    for (const std::string& setting : ours) {
      if (setting.starts_with(key)) return true;
    }
    return false;
  };
  for (char** entry = environ; *entry != nullptr; ++entry) {
    if (!is_ours(*entry)) merged.emplace_back(*entry);
  }
  return merged;
}

void close_all(const Prepared& prepared) {
  for (const int fd : {prepared.output, prepared.gate_read, prepared.gate_write}) {
    if (fd >= 0) ::close(fd);
  }
}

[[noreturn]] void become(const Prepared& prepared) {
  if (prepared.outlives_starter) {
    ::setsid();
    if (const int nothing = ::open("/dev/null", O_RDONLY); nothing >= 0) {
      ::dup2(nothing, STDIN_FILENO);
    }
  } else {
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (::getppid() != prepared.starter) ::_exit(127);
  }
  ::close(prepared.gate_write);
  char permission = 0;
  if (::read(prepared.gate_read, &permission, 1) != 1) ::_exit(127);
  if (prepared.output >= 0) {
    ::dup2(prepared.output, STDOUT_FILENO);
    ::dup2(prepared.output, STDERR_FILENO);
  }
  ::close_range(STDERR_FILENO + 1, ~0U, 0);
  std::signal(SIGPIPE, SIG_DFL);
  sigset_t none;
  sigemptyset(&none);
  ::sigprocmask(SIG_SETMASK, &none, nullptr);
  ::execve(prepared.arguments.front(), prepared.arguments.data(), prepared.environment.data());
  ::_exit(127);
}

Result<void> open_files(const Program& program, Prepared& prepared) {
  if (!program.output.empty()) {
    prepared.output =
        ::open(program.output.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
    if (prepared.output < 0)
      return fail(program.output.string() + ": cannot write: " + std::strerror(errno));
  }
  int gate[2];
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, gate) != 0) {
    return fail(program.command.front() + ": cannot be started: " + std::strerror(errno));
  }
  prepared.gate_read = gate[0];
  prepared.gate_write = gate[1];
  return {};
}

}  // namespace

Result<pid_t> start_program(const Program& program) {
  const std::string& path = program.command.front();
  if (::access(path.c_str(), X_OK) != 0) {
    return fail(path + ": cannot be run: " + std::strerror(errno));
  }
  Prepared prepared;
  prepared.arguments = as_array(program.command);
  prepared.settings = merged_environment(program.environment);
  prepared.environment = as_array(prepared.settings);
  prepared.outlives_starter = program.outlives_starter;
  prepared.starter = ::getpid();
  if (auto opened = open_files(program, prepared); !opened) {
    close_all(prepared);
    return tl::make_unexpected(opened.error());
  }
  const pid_t pid = ::fork();
  if (pid == 0) become(prepared);
  const int problem = errno;
  Result<void> noted;
  if (pid > 0 && program.note) noted = program.note(pid);
  // It waits at the gate: one byte lets it run, the gate's end ends it.
  if (pid > 0 && noted && ::send(prepared.gate_write, "1", 1, MSG_NOSIGNAL) != 1) {
    noted = fail(path + ": cannot be started: " + std::strerror(errno));
  }
  close_all(prepared);
  if (pid < 0) return fail(path + ": cannot be started: " + std::strerror(problem));
  if (noted) return pid;
  ::waitpid(pid, nullptr, 0);
  return tl::make_unexpected(noted.error());
}

std::filesystem::path program_folder() {
  return std::filesystem::read_symlink("/proc/self/exe").parent_path();
}

}  // namespace cairn
