// SPDX-License-Identifier: Apache-2.0
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <memory>
#include <vector>

#include "core/start_program.hpp"
#include "procs/cli/command.hpp"

namespace cairn::cli {
namespace {

// The spy is a program of its own; this one becomes it.
int become_spy(const std::vector<std::string>& words) {
  const std::string program = program_folder() / "cairn-spy";
  std::vector<char*> arguments{const_cast<char*>(program.c_str())};
  for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  ::execv(program.c_str(), arguments.data());
  return failed(program + ": cannot be run: " + std::strerror(errno));
}

}  // namespace

void add_spy(CLI::App& app, Run& run) {
  CLI::App* command =
      app.add_subcommand("spy", "watch live traffic, or a recording, in a terminal");
  command->prefix_command();
  command->set_help_flag();
  command->callback(
      [&run, command] { run = [command] { return become_spy(command->remaining()); }; });
}

}  // namespace cairn::cli
