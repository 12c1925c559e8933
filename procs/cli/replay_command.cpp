// SPDX-License-Identifier: Apache-2.0
#include <memory>

#include "procs/cli/command.hpp"
#include "procs/cli/live_run.hpp"
#include "procs/cli/lockstep_run.hpp"
#include "procs/cli/run_folder.hpp"

namespace cairn::cli {
namespace {

struct Options {
  RunPlan plan;
  bool lockstep = false;
  bool json = false;
  std::string poses;
};

int wrong_usage(const std::string& message) {
  failed(message);
  return kExitUsage;
}

int replay(Options& options) {
  options.plan.truth_poses = options.poses == "truth";
  if (options.plan.truth_poses && !options.lockstep) {
    return wrong_usage("--poses truth: works with --lockstep alone");
  }
  if (!options.poses.empty()) {
    options.plan.implied.push_back(std::string("mapper.pose=") +
                                   (options.poses == "odometry" ? "ODOMETRY" : "POSE"));
  }
  if (auto checked = check_config(options.plan); !checked)
    return wrong_usage(checked.error().message);
  auto plan = complete(options.plan);
  if (!plan) return failed(plan.error().message);
  const auto folder = RunFolder::open(*plan);
  if (!folder) return failed(folder.error().message);
  const auto results = options.lockstep ? run_lockstep(*plan) : run_live(*plan);
  if (!results) return failed(results.error().message);
  print_results(*plan, *results, options.json);
  return results->report.finished ? 0 : kExitFailure;
}

}  // namespace

void add_replay(CLI::App& app, Run& run) {
  auto options = std::make_shared<Options>();
  CLI::App* command =
      app.add_subcommand("replay", "run a recording or a dataset through the processes again");
  command
      ->add_option(
          "source", options->plan.source,
          "an LCM recording; or a folder: EuRoC (mav0), KITTI odometry, or any with a dataset.yaml")
      ->required();
  command->add_flag("--lockstep", options->lockstep,
                    "no sockets, one process, as fast as it goes, the same bytes every time");
  command
      ->add_option("--threads", options->plan.threads,
                   "threads in lockstep; the result does not depend on it")
      ->check(CLI::Range(1, 64));
  command->add_option("--speed", options->plan.speed, "how many times faster than life (live)")
      ->check(CLI::Range(0.01, 100.0));
  command->add_option("--out", options->plan.out, "folder for the results; default out/replay");
  command->add_option("--map", options->plan.map, "map file to go on with");
  command->add_option("--truth", options->plan.truth, "true poses: TUM, KITTI or EuRoC");
  command->add_option("--truth-frame", options->plan.truth_frame, "whose poses the truth gives")
      ->check(CLI::IsMember({"left_camera", "body"}));
  command
      ->add_option(
          "--poses", options->poses,
          "where the mapper takes poses from; default what mapper.pose says: the localizer, "
          "where it is not ODOMETRY (truth: with --lockstep)")
      ->check(CLI::IsMember({"localizer", "odometry", "truth"}));
  command->add_option(
      "--config", options->plan.config_file,
      "YAML file with a section for each process; default: of a recording that a run made, "
      "the config of that run");
  command->add_option("--set", options->plan.settings, "PROCESS.KEY=VALUE, wins over the file")
      ->allow_extra_args(false);
  command->add_option("--lcm-url", options->plan.lcm_url, "bus of a live run");
  command->add_flag("--record-all", options->plan.record_all,
                    "recording.lcmlog gets DISPARITY and MAP_DELTA too");
  command->add_flag("--json", options->json, "print report.json instead of words");
  command->footer("Example:\n  cairn replay recordings/street --lockstep --out out/street");
  command->callback([&run, options] { run = [options] { return replay(*options); }; });
}

}  // namespace cairn::cli
