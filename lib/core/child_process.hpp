// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/result.hpp"

namespace cairn {

/// A program that was started; killed where this goes away while it still runs. It also dies with
/// its starter.
class ChildProcess {
 public:
  /// What it prints goes into the file `output` (appended), or where ours goes if that is empty.
  [[nodiscard]] static Result<ChildProcess> start(const std::vector<std::string>& command,
                                                  const std::filesystem::path& output);

  ChildProcess(ChildProcess&& other) noexcept;
  ChildProcess& operator=(ChildProcess&& other) noexcept;
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;
  ~ChildProcess();

  void signal(int number) const;

  /// Its exit code once it has ended (minus the signal's number if it was killed), else nothing.
  [[nodiscard]] std::optional<int> exit_code();

  /// Waits for its end; its exit code.
  int wait();

  [[nodiscard]] pid_t pid() const { return pid_; }

 private:
  explicit ChildProcess(pid_t pid) : pid_{pid} {}
  void end();
  void look(int options);

  pid_t pid_ = 0;
  std::optional<int> exit_code_;
};

}  // namespace cairn
