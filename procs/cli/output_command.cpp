// SPDX-License-Identifier: Apache-2.0
#include <filesystem>
#include <fstream>
#include <iostream>
#include <memory>

#include "bus/stop_signal.hpp"
#include "procs/cli/command.hpp"
#include "procs/cli/group_session.hpp"
#include "procs/cli/output_lines.hpp"

namespace cairn::cli {
namespace {

namespace fs = std::filesystem;

constexpr std::int64_t kLookPeriod_us = 100'000;

struct Options {
  std::string process;
  int lines = 50;
  bool follow = false;
  fs::path run;
  std::string lcm_url;
};

Result<fs::path> run_folder(const Options& options) {
  if (!options.run.empty()) return options.run;
  const auto session = GroupSession::open(options.lcm_url);
  if (!session) return tl::make_unexpected(session.error());
  if (auto found = (*session)->find_supervisor(); !found) {
    return fail(found.error().message + "\nOf a run that has ended: --out RUN");
  }
  return fs::path((*session)->group().state()->run);
}

// Until a signal comes; a file that shrinks is a new one.
void follow(const fs::path& log, bus::StopSignal& stop) {
  std::error_code error;
  std::uintmax_t position = fs::file_size(log, error);
  while (!stop.arrived(kLookPeriod_us)) {
    const std::uintmax_t size = fs::file_size(log, error);
    if (error || size == position) continue;
    if (size < position) position = 0;
    std::ifstream stream(log, std::ios::binary);
    stream.seekg(static_cast<std::streamoff>(position));
    std::string text(static_cast<std::size_t>(size - position), '\0');
    stream.read(text.data(), static_cast<std::streamsize>(text.size()));
    std::cout << text << std::flush;
    position = size;
  }
}

int output(const Options& options) {
  bus::StopSignal stop;
  const auto run = run_folder(options);
  if (!run) return failed(run.error().message);
  const fs::path log = *run / "log" / (options.process + ".log");
  std::error_code error;
  if (!fs::is_regular_file(log, error)) {
    std::string names;
    for (const auto& entry : fs::directory_iterator(*run / "log", error)) {
      names += (names.empty() ? "" : ", ") + entry.path().stem().string();
    }
    return failed(log.string() + ": no such file; there is output of: " + names);
  }
  for (const std::string& line : last_lines(log, static_cast<std::size_t>(options.lines))) {
    std::cout << line << "\n";
  }
  std::cout << std::flush;
  if (options.follow) follow(log, stop);
  return 0;
}

}  // namespace

void add_output(CLI::App& app, Run& run) {
  auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand("output", "what a process of the group printed");
  command->add_option("process", options->process, "its name, as cairn ps shows it; or supervisor")
      ->required();
  command->add_option("-n", options->lines, "how many of the last lines")
      ->check(CLI::Range(0, 1'000'000))
      ->capture_default_str();
  command->add_flag("--follow,-f", options->follow, "go on with what it prints, until Ctrl-C");
  command->add_option("--out", options->run, "folder of a run, for one that has ended");
  command->add_option("--lcm-url", options->lcm_url, "bus of the group");
  command->footer("Example:\n  cairn output mapper -n 20 --follow");
  command->callback([&run, options] { run = [options] { return output(*options); }; });
}

}  // namespace cairn::cli
