// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "bus/host_clock.hpp"
#include "bus/process.hpp"
#include "bus/stop_signal.hpp"
#include "motor/serial_link.hpp"
#include "motor/step_trial.hpp"
#include "procs/cli/command.hpp"
#include "procs/motor/motor_node.hpp"

namespace cairn::cli {
namespace {

using nlohmann::json;

struct Options {
  ConfigSource config;
  bool off_the_ground = false;
  bool as_json = false;
};

json to_json(const motor::StepFit& fit) {
  return {{"full_duty_mps", fit.full_duty_mps}, {"response_s", fit.response_s}};
}

void print(const std::array<motor::StepFit, 2>& fits, const motor::TrackPidConfig& pid) {
  for (std::size_t i = 0; i < 2; ++i) {
    std::printf("%s track: %.3f m/s at full duty, follows after %.0f ms\n",
                i == 0 ? "left" : "right", fits[i].full_duty_mps, 1e3 * fits[i].response_s);
  }
  const double difference = std::abs(fits[0].full_duty_mps / fits[1].full_duty_mps - 1);
  if (difference > 0.2)
    std::printf("the tracks differ by %.0f %%: look at the slower one\n", 100 * difference);
  std::printf(
      "for the robot's file:\nmotor:\n  pid:\n    full_duty_mps: %.3f\n    response_s: %.3f\n"
      "    proportional: %.2f\n    integral: %.2f\n",
      pid.full_duty_mps, pid.response_s, pid.proportional, pid.integral);
}

// A robot that STOP holds is held here, too.
Result<void> may_turn(const Options& options, const MotorConfig& config) {
  if (!options.off_the_ground)
    return fail(
        "motor tune turns the tracks at up to half speed, whatever stands before them: put "
        "the robot on blocks and say --yes-the-tracks-are-off-the-ground");
  const auto path = motor::LatchFile::locate(config.latch_file);
  if (!path) return tl::make_unexpected(path.error());
  const auto latch = motor::LatchFile(*path).load();
  if (latch.latched) return fail("latched: STOP by " + latch.by + "; release it first");
  return {};
}

int tune(const Options& options) {
  const auto config = load_config<MotorConfig>(options.config, "motor", bus::kConfigSections);
  if (!config) {
    std::cerr << config.error().message << "\n";
    return kExitUsage;
  }
  if (auto may = may_turn(options, *config); !may) return failed(may.error().message);
  bus::StopSignal signal;
  const bus::SteadyClock clock;
  const auto open = [&]() -> Result<std::unique_ptr<motor::ByteLink>> {
    return motor::SerialLink::open(config->device, config->baud);
  };
  motor::StepTrial trial(motor::WheelLine(config->device, open), config->robot.ticks_per_m,
                         clock.now_us());
  while (trial.tick(clock.now_us())) {
    if (signal.arrived(motor::StepTrial::kTick_us)) trial.stop();
  }
  const auto fits = trial.result();
  if (!fits) return failed(fits.error().message);
  const motor::StepFit mean{(fits->at(0).full_duty_mps + fits->at(1).full_duty_mps) / 2,
                            std::max(fits->at(0).response_s, fits->at(1).response_s)};
  const motor::TrackPidConfig pid = motor::settings_for(mean);
  if (!options.as_json) {
    print(*fits, pid);
    return 0;
  }
  std::cout << json{{"left", to_json(fits->at(0))},
                    {"right", to_json(fits->at(1))},
                    {"pid",
                     {{"full_duty_mps", pid.full_duty_mps},
                      {"response_s", pid.response_s},
                      {"proportional", pid.proportional},
                      {"integral", pid.integral}}}}
                   .dump(2)
            << "\n";
  return 0;
}

}  // namespace

void add_motor(CLI::App& app, Run& run) {
  auto options = std::make_shared<Options>();
  CLI::App* motor = app.add_subcommand("motor", "the wheels: tune");
  motor->require_subcommand(1);
  CLI::App* command = motor->add_subcommand(
      "tune", "drive each track with a step, and suggest settings; motor must not run");
  command->add_option("--config", options->config.file, "the robot's file")->type_name("FILE");
  command->add_option("--set", options->config.overrides, "a key of motor's for this run")
      ->type_name("KEY=VALUE")
      ->allow_extra_args(false);
  command->add_flag("--yes-the-tracks-are-off-the-ground", options->off_the_ground,
                    "what a person has made sure of; without it nothing moves");
  command->add_flag("--json", options->as_json, "for scripts");
  command->footer(
      "Example:\n  cairn motor tune --config config/robots/webcams.yaml --set device=/dev/ttyUSB0 "
      "--yes-the-tracks-are-off-the-ground");
  command->callback([&run, options] { run = [options] { return tune(*options); }; });
}

}  // namespace cairn::cli
