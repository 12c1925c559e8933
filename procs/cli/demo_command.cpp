// SPDX-License-Identifier: Apache-2.0
#include <memory>

#include "procs/cli/command.hpp"
#include "procs/cli/demo_run.hpp"
#include "procs/cli/run_folder.hpp"

namespace cairn::cli {
namespace {

struct Options {
  DemoPlan plan;
  bool headless = false;
  bool json = false;
};

// All that can be wrong is found before anything starts, or is written.
int demo(const Options& options) {
  DemoPlan settled = with_settings(options.plan);
  if (auto checked = check_config(settled.run); !checked) {
    failed(checked.error().message);
    return kExitUsage;
  }
  auto plan = complete(std::move(settled));
  if (!plan) return failed(plan.error().message);
  auto place = SimulatedPlace::load(plan->simulator, plan->max_disparity_px);
  if (!place) return failed(place.error().message);
  const auto group = plan->fast ? GroupConfig{} : demo_group(*plan);
  if (!group) return failed(group.error().message);
  const auto folder = RunFolder::open(plan->run);
  if (!folder) return failed(folder.error().message);
  const auto results =
      plan->fast ? run_fast_demo(*plan, *place) : run_live_demo(*plan, *group, *place);
  if (!results) return failed(results.error().message);
  print_results(plan->run, *results, options.json);
  return results->report.finished ? 0 : kExitFailure;
}

}  // namespace

void add_demo(CLI::App& app, Run& run) {
  auto options = std::make_shared<Options>();
  DemoPlan& plan = options->plan;
  plan.run.out = "out/demo";
  plan.run.threads = 2;
  CLI::App* command = app.add_subcommand(
      "demo", "a simulated robot explores a place that it has never seen, and maps it");
  command->add_option("--world", plan.world, "world file; default config/worlds/room.yaml");
  command->add_option("--seed", plan.seed, "of all that is random in the simulated world")
      ->check(CLI::Range(0, 1'000'000'000))
      ->capture_default_str();
  command->add_option("--people", plan.people, "how many of the world's people walk about")
      ->check(CLI::Range(0, 100))
      ->capture_default_str();
  command->add_flag("--headless", options->headless, "without a web page (there is none yet)");
  auto* fast = command->add_flag(
      "--fast", plan.fast,
      "many times faster than life, in one process: true depth and motion with measured errors in "
      "place of images; for statistics only");
  command
      ->add_option("--speed", plan.run.speed,
                   "how many times faster than life at most; above 1 frames wait for the robot")
      ->check(CLI::Range(0.1, 50.0))
      ->capture_default_str()
      ->excludes(fast);
  command->add_option("--time-limit", plan.time_limit_s, "ends after so many simulated seconds")
      ->check(CLI::Range(1.0, 1e6))
      ->capture_default_str();
  command->add_option("--map", plan.run.map, "map file to go on with");
  command->add_option("--out", plan.run.out, "folder for the results")->capture_default_str();
  command->add_option("--config", plan.run.config_file,
                      "YAML file with a section for each process; default "
                      "config/robots/simulated.yaml, with --fast simulated-fast.yaml");
  command->add_option("--set", plan.run.settings, "PROCESS.KEY=VALUE, wins over the file")
      ->allow_extra_args(false);
  command->add_option("--lcm-url", plan.run.lcm_url, "bus of the processes");
  command
      ->add_option("--threads", plan.run.threads,
                   "threads of a fast run; the result does not depend on it")
      ->check(CLI::Range(1, 64))
      ->capture_default_str();
  command->add_flag("--record-all", plan.run.record_all,
                    "recording.lcmlog gets DISPARITY and MAP_DELTA too");
  command->add_flag("--json", options->json, "print report.json instead of words");
  command->footer(
      "Examples:\n"
      "  cairn demo --world config/worlds/apartment.yaml --out out/apartment\n"
      "  cairn demo --fast --people 2 --seed 7 --world config/worlds/apartment.yaml");
  command->callback([&run, options] { run = [options] { return demo(*options); }; });
}

}  // namespace cairn::cli
