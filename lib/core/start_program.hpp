// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "core/result.hpp"

namespace cairn {

/// A program and what it is started with.
struct Program {
  std::vector<std::string> command;  ///< path of the executable, then its arguments
  std::filesystem::path output;  ///< what it prints is appended there; empty: goes where ours goes
  std::vector<std::string> environment;  ///< "KEY=VALUE"; win over ours
  /// False: it is killed when the thread that started it ends. True: it goes on in a session of its
  /// own, out of reach of our terminal.
  bool outlives_starter = false;
  /// Called with its pid before it runs. If this fails, or if we are killed in it, the program
  /// never runs: so nothing runs that was not noted.
  std::function<Result<void>(pid_t)> note;
};

/// Starts it; the value is its pid, which the caller must wait for. It gets no file of ours but the
/// three standard ones, and no blocked or ignored signal.
[[nodiscard]] Result<pid_t> start_program(const Program& program);

/// The folder of the running program, where the other programs of the project are.
[[nodiscard]] std::filesystem::path program_folder();

}  // namespace cairn
