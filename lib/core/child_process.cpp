// SPDX-License-Identifier: Apache-2.0
#include "core/child_process.hpp"

#include <sys/wait.h>

#include <csignal>
#include <utility>

#include "core/start_program.hpp"

namespace cairn {

Result<ChildProcess> ChildProcess::start(const std::vector<std::string>& command,
                                         const std::filesystem::path& output) {
  Program program;
  program.command = command;
  program.output = output;
  const auto pid = start_program(program);
  if (!pid) return tl::make_unexpected(pid.error());
  return ChildProcess(*pid);
}

ChildProcess::ChildProcess(ChildProcess&& other) noexcept
    : pid_{std::exchange(other.pid_, 0)}, exit_code_{other.exit_code_} {}

ChildProcess& ChildProcess::operator=(ChildProcess&& other) noexcept {
  end();
  pid_ = std::exchange(other.pid_, 0);
  exit_code_ = other.exit_code_;
  return *this;
}

ChildProcess::~ChildProcess() { end(); }

void ChildProcess::end() {
  if (pid_ == 0 || exit_code()) return;
  ::kill(pid_, SIGKILL);
  ::waitpid(pid_, nullptr, 0);
}

void ChildProcess::signal(int number) const {
  if (pid_ != 0 && !exit_code_) ::kill(pid_, number);
}

std::optional<int> ChildProcess::exit_code() {
  look(WNOHANG);
  return exit_code_;
}

int ChildProcess::wait() {
  look(0);
  return exit_code_.value_or(-1);
}

void ChildProcess::look(int options) {
  int status = 0;
  if (!exit_code_ && ::waitpid(pid_, &status, options) == pid_) {
    exit_code_ = WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
  }
}

}  // namespace cairn
