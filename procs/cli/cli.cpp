// SPDX-License-Identifier: Apache-2.0
#include "procs/cli/cli.hpp"

#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <iostream>
#include <opencv2/core.hpp>

#include "procs/cli/command.hpp"

namespace cairn::cli {

int failed(const std::string& message) {
  std::cerr << message << "\n";
  return kExitFailure;
}

int run(int argc, char** argv) {
  CLI::App app{"cairn: a robot's eyes, memory and judgement", "cairn"};
  app.set_version_flag("--version", std::string("cairn ") + CAIRN_VERSION);
  app.require_subcommand(1);
  app.footer("Each word has its own --help with an example.");
  Run run;
  for (const auto add :
       {add_demo, add_up, add_keep, add_down, add_ps, add_process_words, add_output, add_replay,
        add_record, add_stereo, add_eval, add_map, add_spy, add_release, add_drive, add_motor}) {
    add(app, run);
  }
  // The script in the root does this one before it gets here; it is listed for people.
  app.add_subcommand("test", "build and run every test")->callback([&] {
    run = [] {
      return failed("'test' is a word of the cairn script in the root of the source: ./cairn test");
    };
  });
  const std::string word = argc > 1 ? argv[1] : "-";
  const auto named = [&](const CLI::App* command) { return command->get_name() == word; };
  if (!word.starts_with('-') && app.get_subcommands(named).empty()) {
    std::cerr << "unknown word '" << argv[1] << "'; cairn --help lists them\n";
    return kExitUsage;
  }
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : kExitUsage;
  }
  spdlog::set_default_logger(spdlog::stderr_color_mt("cairn"));
  spdlog::set_pattern("%^%l%$ %v");
  spdlog::set_level(spdlog::level::warn);
  cv::setNumThreads(1);
  return run();
}

}  // namespace cairn::cli
