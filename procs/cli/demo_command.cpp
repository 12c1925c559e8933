// SPDX-License-Identifier: Apache-2.0
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <memory>

#include "camera/rig_calibration.hpp"
#include "procs/cli/command.hpp"
#include "procs/cli/live_run.hpp"
#include "procs/cli/map_against_world.hpp"
#include "procs/cli/run_folder.hpp"
#include "procs/cli/shared_files.hpp"
#include "simulation/drive_path.hpp"
#include "simulation/sequence.hpp"
#include "simulation/world.hpp"

namespace cairn::cli {
namespace {

struct Options {
  RunPlan plan;
  std::string world;
  int seed = 1;
  bool headless = false;
  bool json = false;
};

/// The paper's rig: two webcams 25.4 cm apart, 640x480, 60 degrees wide, on a small robot.
camera::RigCalibration demo_rig() {
  constexpr int kWidth_px = 640;
  constexpr int kHeight_px = 480;
  constexpr double kBaseline_m = 0.254;
  constexpr double kHeight_m = 0.45;
  const double f_px = 0.5 * kWidth_px / std::tan(M_PI / 6);
  Isometry T_body_left = Isometry::Identity();
  T_body_left.translate(Eigen::Vector3d(0, 0.5 * kBaseline_m, kHeight_m))
      .rotate(R_body_camera_forward());
  return camera::rectified_rig(f_px, f_px, 0.5 * (kWidth_px - 1), 0.5 * (kHeight_px - 1),
                               kBaseline_m, kWidth_px, kHeight_px, T_body_left);
}

void show_rendering(std::size_t done, std::size_t all) {
  if (::isatty(STDERR_FILENO) == 0) return;
  std::fprintf(stderr, "\rrendering what the robot will see: %zu of %zu%s", done, all,
               done == all ? "\r\033[K" : "");
}

int demo(Options& options) {
  if (auto checked = check_config(options.plan); !checked) {
    failed(checked.error().message);
    return kExitUsage;
  }
  const auto world =
      simulation::load_world(options.world.empty() ? shared_file("config/worlds/room.yaml")
                                                   : std::filesystem::path(options.world));
  if (!world) return failed(world.error().message);
  const camera::RigCalibration rig = demo_rig();
  const evaluation::Trajectory path = simulation::drive_round(simulation::room_tour_m(), {});
  simulation::SequenceConfig sequence;
  sequence.seed = static_cast<std::uint64_t>(options.seed);
  const auto folder = RunFolder::open(options.plan);
  if (!folder) return failed(folder.error().message);
  std::fprintf(stderr, "rendering %zu views of a room, then driving through it\n", path.size());
  options.plan.source = options.plan.out / "sequence";
  const auto rendered =
      simulation::render_sequence(*world, rig, path, sequence, options.plan.source, show_rendering);
  if (!rendered) return failed(rendered.error().message);
  const auto plan = complete(options.plan);
  if (!plan) return failed(plan.error().message);
  const auto results = run_live(*plan, map_against_world(*world, rig, path));
  if (!results) return failed(results.error().message);
  print_results(*plan, *results, options.json);
  return results->report.finished ? 0 : kExitFailure;
}

}  // namespace

void add_demo(CLI::App& app, Run& run) {
  auto options = std::make_shared<Options>();
  options->plan.out = "out/demo";
  CLI::App* command = app.add_subcommand(
      "demo", "drive once round a rendered room; the live processes see, follow and map it");
  command->add_option("--world", options->world, "world file; default config/worlds/room.yaml");
  command->add_option("--seed", options->seed, "of the camera noise")
      ->check(CLI::Range(0, 1'000'000'000));
  command->add_flag("--headless", options->headless, "without a web page (there is none yet)");
  command->add_option("--speed", options->plan.speed, "how many times faster than life")
      ->check(CLI::Range(0.01, 100.0));
  command->add_option("--map", options->plan.map, "map file to go on with");
  command->add_option("--out", options->plan.out, "folder for the results")->capture_default_str();
  command->add_option("--lcm-url", options->plan.lcm_url, "bus of the processes");
  command->add_option("--set", options->plan.settings, "PROCESS.KEY=VALUE")
      ->allow_extra_args(false);
  command->add_flag("--record-all", options->plan.record_all,
                    "recording.lcmlog gets DISPARITY and MAP_DELTA too");
  command->add_flag("--json", options->json, "print report.json instead of words");
  command->footer("Example:\n  cairn demo --headless --out out/demo");
  command->callback([&run, options] { run = [options] { return demo(*options); }; });
}

}  // namespace cairn::cli
