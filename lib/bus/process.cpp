// SPDX-License-Identifier: Apache-2.0
#include "bus/process.hpp"

#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <cstdlib>
#include <iostream>
#include <opencv2/core.hpp>
#include <random>

#include "bus/log_format.hpp"
#include "bus/stop_signal.hpp"

namespace cairn::bus {
namespace {

constexpr int kExitUsage = 2;
constexpr int kExitFailure = 1;
/// How long a stop signal may go unnoticed while nothing arrives.
constexpr std::int64_t kLongestWait_us = 50'000;

struct Options {
  ConfigSource config;
  bool print_config = false;
  bool check = false;
  bool reference = false;
  std::string log_level = "info";
  std::string lcm_url;
  std::string state;
};

void declare(CLI::App& app, Options& options, const std::string& name) {
  app.add_option("--config", options.config.file,
                 "YAML file; the section '" + name + "' is this process's")
      ->type_name("FILE");
  app.add_option("--set", options.config.overrides, "a config key for this run; wins over the file")
      ->type_name("KEY=VALUE")
      ->allow_extra_args(false);
  app.add_flag("--print-config", options.print_config,
               "print the effective config with help, and exit");
  app.add_flag("--config-reference", options.reference,
               "print all config keys as a Markdown table, and exit");
  app.add_flag("--check", options.check, "load the config, say whether it is good, and exit");
  app.add_option("--log-level", options.log_level, "what to print")
      ->check(CLI::IsMember({"debug", "info", "warn", "error"}))
      ->capture_default_str();
  app.add_option("--lcm-url", options.lcm_url,
                 "udpm://GROUP:PORT?ttl=0 or file:///RECORDING; default $LCM_DEFAULT_URL, else "
                 "udpm://239.255.76.67:7667?ttl=0");
  app.add_option("--state", options.state,
                 "folder of this run's checkpoints; none: nothing survives a restart")
      ->type_name("DIR");
  app.set_version_flag("--version", std::string("cairn ") + CAIRN_VERSION);
  app.footer("Example:\n  cairn-" + name +
             " --config config/robots/webcams.yaml --state logs/run-1/" + name);
}

std::int64_t random_session() {
  std::random_device device;
  const std::uint64_t bits = (std::uint64_t{device()} << 32 | device()) & 0x7fffffffffffffffULL;
  return static_cast<std::int64_t>(bits);
}

// Not in the form of a log line: those have been heard on the bus.
int failed(const Error& error) {
  std::cerr << error.message << "\n";
  return kExitFailure;
}

int run(const ProcessDescription& description, const Options& options) {
  StopSignal stop;
  // What this process starts talks on the same bus.
  ::setenv("LCM_DEFAULT_URL", effective_url(options.lcm_url).c_str(), 1);
  const auto bus = open_bus(options.lcm_url);
  if (!bus) return failed(bus.error());
  StateFolder state;
  if (!options.state.empty()) {
    auto opened = StateFolder::open(options.state);
    if (!opened) return failed(opened.error());
    state = std::move(*opened);
  }
  const SteadyClock clock;
  Node node(description.name, **bus, clock, std::move(state), random_session());
  const auto finish = description.start(node);
  const Result<void> started = !finish ? tl::make_unexpected(finish.error()) : node.wiring();
  if (!started) return failed(started.error());
  spdlog::info("{}: ready", description.name);
  while (!node.stopping() && !stop.arrived()) node.spin_once(kLongestWait_us);
  const auto finished = (*finish)();
  node.publish_status();
  return finished ? 0 : failed(finished.error());
}

}  // namespace

int run_process(int argc, char** argv, ProcessDescription description) {
  Options options;
  CLI::App app{description.about, "cairn-" + description.name};
  declare(app, options, description.name);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : kExitUsage;
  }
  spdlog::set_default_logger(spdlog::stderr_color_mt("cairn"));
  spdlog::set_pattern(kLogPattern);
  spdlog::set_level(spdlog::level::from_str(options.log_level));
  cv::setNumThreads(1);
  if (options.reference) {
    std::cout << config_reference(description.visit_config);
    return 0;
  }
  const auto loaded =
      load_config(options.config, description.name, kConfigSections, description.visit_config);
  if (!loaded) {
    std::cerr << loaded.error().message << "\n";
    return kExitUsage;
  }
  if (auto checked = description.check(); !checked) {
    std::cerr << checked.error().message << "\n";
    return kExitUsage;
  }
  if (options.print_config) {
    std::cout << print_config(description.name, description.visit_config);
    return 0;
  }
  if (options.check) {
    std::cout << "the config is good\n";
    return 0;
  }
  return run(description, options);
}

}  // namespace cairn::bus
