// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <numeric>

#include "bus/channels.hpp"
#include "bus/codec.hpp"
#include "bus/recording.hpp"
#include "evaluation/map_agreement.hpp"
#include "evaluation/stereo_score.hpp"
#include "evaluation/trajectory_score.hpp"
#include "mapping/map_file.hpp"
#include "messages/geometry_messages.hpp"
#include "procs/cli/command.hpp"
#include "procs/cli/truth.hpp"

namespace cairn::cli {
namespace {

using Json = nlohmann::ordered_json;

struct Options {
  std::string estimate;
  std::string truth;
  double tolerance_m = 0.05;
  bool as_they_lie = false;
  std::string mask;
  std::string truth_frame;
  double rate_hz = 10;
  bool json = false;
};

Json or_null(const std::optional<double>& value) { return value ? Json(*value) : Json(nullptr); }

// POSE where a localizer ran, else ODOMETRY.
Result<evaluation::Trajectory> trajectory_of_recording(const std::string& file) {
  auto reader = bus::RecordingReader::open(file);
  if (!reader) return tl::make_unexpected(reader.error());
  evaluation::Trajectory poses;
  evaluation::Trajectory odometry;
  const auto append = [](evaluation::Trajectory& trajectory, Utime utime,
                         const Result<Isometry>& T) {
    if (T && (trajectory.empty() || utime > trajectory.back().utime))
      trajectory.push_back({utime, *T});
  };
  while (const auto event = reader->next()) {
    if (event->message.channel == bus::channels::Pose::name) {
      const auto pose = bus::decode<pose_t>(event->message.bytes);
      if (pose)
        append(poses, pose->header.utime, messages::to_isometry(pose->T_map_body, "T_map_body"));
    } else if (event->message.channel == bus::channels::Odometry::name) {
      const auto pose = bus::decode<odometry_t>(event->message.bytes);
      if (pose)
        append(odometry, pose->header.utime,
               messages::to_isometry(pose->T_odom_body, "T_odom_body"));
    }
  }
  if (!reader->damage().empty()) std::cerr << reader->damage() << "\n";
  if (poses.empty() && odometry.empty()) return fail(file + ": holds no POSE and no ODOMETRY");
  return poses.empty() ? odometry : poses;
}

Result<evaluation::Trajectory> read_estimate(const Options& options) {
  if (options.estimate.ends_with(".lcmlog")) return trajectory_of_recording(options.estimate);
  const auto format = guess_format(options.estimate);
  if (!format) return tl::make_unexpected(format.error());
  std::vector<Utime> times;
  if (*format == "kitti") {
    std::ifstream stream(options.estimate);
    for (std::string line; std::getline(stream, line);) {
      times.push_back(std::llround(1e6 * static_cast<double>(times.size()) / options.rate_hz));
    }
  }
  return evaluation::read_trajectory(options.estimate, *format, times);
}

Result<evaluation::Trajectory> read_truth(const Options& options,
                                          const evaluation::Trajectory& estimate) {
  // KITTI truth has no times; its lines are the frames, at the rate that was given, from the
  // estimate's first on.
  std::vector<Utime> times;
  std::ifstream stream(options.truth);
  for (std::string line; std::getline(stream, line);) {
    times.push_back(estimate.front().utime +
                    std::llround(1e6 * static_cast<double>(times.size()) / options.rate_hz));
  }
  return read_body_truth(options.truth, "", options.truth_frame, times,
                         Isometry(R_body_camera_forward()));
}

void print(const evaluation::TrajectoryScore& score) {
  std::printf("pairs %zu, way %.3f m, %.2f s\n", score.pairs, score.length_m, score.duration_s);
  std::printf("ATE rmse %.4f m (mean %.4f, median %.4f, max %.4f)\n", score.ate_m.rmse,
              score.ate_m.mean, score.ate_m.median, score.ate_m.max);
  std::printf("aligned at the first pose: end point off by %.4f m", score.end.position_m);
  if (score.end.fraction_of_way)
    std::printf(" (%.3f %% of the way)", 100 * *score.end.fraction_of_way);
  std::printf(", yaw off by %.3f degrees\n", score.end.yaw_rad * 180 / M_PI);
  const auto print_relative = [](const char* name,
                                 const std::optional<evaluation::RelativeError>& error) {
    if (!error) return;
    std::printf("RPE over %s: %.4f m, %.3f degrees\n", name, error->translation_rmse_m,
                error->rotation_rmse_rad * 180 / M_PI);
  };
  print_relative("1 m", score.rpe_1m);
  print_relative("1 s", score.rpe_1s);
  if (score.drift_kitti) {
    std::printf("KITTI drift %.3f %%, %.5f degrees/m\n", score.drift_kitti->translation_percent,
                score.drift_kitti->rotation_deg_per_m);
  }
  if (score.drift_indoor) {
    std::printf("indoor-KITTI drift (1 to 8 m) %.3f %%, %.5f degrees/m\n",
                score.drift_indoor->translation_percent, score.drift_indoor->rotation_deg_per_m);
  }
}

Json to_json(const evaluation::TrajectoryScore& score) {
  return Json{{"pairs", score.pairs},
              {"length_m", score.length_m},
              {"duration_s", score.duration_s},
              {"ate_rmse_m", score.ate_m.rmse},
              {"ate_mean_m", score.ate_m.mean},
              {"ate_median_m", score.ate_m.median},
              {"ate_max_m", score.ate_m.max},
              {"end_error_m", score.end.position_m},
              {"end_error_fraction", or_null(score.end.fraction_of_way)},
              {"end_yaw_error_rad", score.end.yaw_rad},
              {"rpe_1m", score.rpe_1m ? Json(score.rpe_1m->translation_rmse_m) : Json(nullptr)},
              {"rpe_1m_rad", score.rpe_1m ? Json(score.rpe_1m->rotation_rmse_rad) : Json(nullptr)},
              {"rpe_1s", score.rpe_1s ? Json(score.rpe_1s->translation_rmse_m) : Json(nullptr)},
              {"rpe_1s_rad", score.rpe_1s ? Json(score.rpe_1s->rotation_rmse_rad) : Json(nullptr)},
              {"kitti_t_rel_percent",
               score.drift_kitti ? Json(score.drift_kitti->translation_percent) : Json(nullptr)},
              {"indoor_t_rel_percent",
               score.drift_indoor ? Json(score.drift_indoor->translation_percent) : Json(nullptr)}};
}

int eval_trajectory(const Options& options) {
  const auto estimate = read_estimate(options);
  if (!estimate) return failed(estimate.error().message);
  const auto truth = read_truth(options, *estimate);
  if (!truth) return failed(truth.error().message);
  const auto score = evaluation::score_trajectory(*estimate, *truth);
  if (!score) return failed(score.error().message);
  if (options.json) {
    std::cout << to_json(*score).dump(2) << "\n";
  } else {
    print(*score);
  }
  return 0;
}

Result<evaluation::StereoScore> stereo_score(const Options& options) {
  evaluation::StereoCase images;
  auto answer = evaluation::read_disparity_png(options.estimate);
  if (!answer) return tl::make_unexpected(answer.error());
  auto truth = evaluation::read_disparity_png(options.truth);
  if (!truth) return tl::make_unexpected(truth.error());
  images.answer_px = *answer;
  images.truth_px = *truth;
  if (!options.mask.empty()) {
    auto mask = evaluation::read_mask_png(options.mask);
    if (!mask) return tl::make_unexpected(mask.error());
    images.mask = *mask;
  }
  return evaluation::score_stereo(images);
}

int eval_stereo(const Options& options) {
  const auto score = stereo_score(options);
  if (!score) return failed(score.error().message);
  const Json json{{"truth_pixels", score->truth_pixels}, {"density", score->density},
                  {"bad1", or_null(score->bad1)},        {"bad2", or_null(score->bad2)},
                  {"bad2_invalid", score->bad2_invalid}, {"d1", or_null(score->d1)},
                  {"epe", or_null(score->epe_px)},       {"rms", or_null(score->rms_px)},
                  {"median", or_null(score->median_px)}, {"p95", or_null(score->p95_px)}};
  if (options.json) {
    std::cout << json.dump(2) << "\n";
    return 0;
  }
  for (const auto& [name, value] : json.items())
    std::printf("%-13s %s\n", name.c_str(), value.dump().c_str());
  return 0;
}

std::vector<Eigen::Vector3d> surface_of(const mapping::VoxelMap& map, const Isometry& T) {
  std::vector<Eigen::Vector3d> points_m;
  map.grid().for_each([&](mapping::BrickIndex brick, const mapping::EvidenceBrick& evidence) {
    mapping::for_each_voxel(evidence.occupied, [&](int voxel) {
      points_m.push_back(T * map.centre_of(mapping::voxel_in(brick, voxel)));
    });
  });
  return points_m;
}

// T_reference_map by the trajectories that lie beside the two maps; nothing where there are none.
std::optional<Isometry> alignment_by_trajectories(const Options& options) {
  const auto beside = [](const std::string& map) {
    const auto file = std::filesystem::path(map).parent_path() / "trajectory.tum";
    return std::filesystem::exists(file)
               ? evaluation::read_tum(file)
               : Result<evaluation::Trajectory>(fail(file.string() + ": no such file"));
  };
  const auto estimate = beside(options.estimate);
  const auto reference = beside(options.truth);
  if (!estimate || !reference) return std::nullopt;
  const auto pairs = evaluation::associate(*estimate, *reference);
  if (pairs.empty()) return std::nullopt;
  return evaluation::align_maps(pairs);
}

int eval_map(const Options& options) {
  const auto map = mapping::load_map(options.estimate, {});
  if (!map) return failed(map.error().message);
  const auto reference = mapping::load_map(options.truth, {});
  if (!reference) return failed(reference.error().message);
  std::optional<Isometry> T_reference_map;
  if (!options.as_they_lie) T_reference_map = alignment_by_trajectories(options);
  const auto agreement = evaluation::map_agreement(
      surface_of(map->map, T_reference_map.value_or(Isometry::Identity())),
      surface_of(reference->map, Isometry::Identity()), options.tolerance_m);
  const Json json{{"occupied_voxels", agreement.points},
                  {"reference_voxels", agreement.reference_points},
                  {"tolerance_m", agreement.tolerance_m},
                  {"aligned_by", T_reference_map ? "trajectories" : "nothing"},
                  {"precision", or_null(agreement.precision)},
                  {"recall", or_null(agreement.recall)},
                  {"f_score", or_null(agreement.f_score)}};
  if (options.json) {
    std::cout << json.dump(2) << "\n";
    return 0;
  }
  for (const auto& [name, value] : json.items())
    std::printf("%-16s %s\n", name.c_str(), value.dump().c_str());
  return 0;
}

}  // namespace

void add_eval(CLI::App& app, Run& run) {
  CLI::App* command = app.add_subcommand("eval", "score a result against the truth");
  command->require_subcommand(1);

  auto options = std::make_shared<Options>();
  CLI::App* trajectory = command->add_subcommand("trajectory", "ATE, RPE, drift, error at the end");
  trajectory
      ->add_option("estimate", options->estimate, "TUM, KITTI, EuRoC, or a recording (.lcmlog)")
      ->required();
  trajectory->add_option("truth", options->truth, "TUM, KITTI or EuRoC")->required();
  trajectory
      ->add_option("--truth-frame", options->truth_frame,
                   "whose poses the truth gives; default left_camera for KITTI")
      ->check(CLI::IsMember({"left_camera", "body"}));
  trajectory
      ->add_option("--rate", options->rate_hz,
                   "frames per second of KITTI files, which have no times")
      ->check(CLI::Range(0.1, 1000.0))
      ->capture_default_str();
  trajectory->add_flag("--json", options->json, "print JSON instead of words");
  trajectory->footer(
      "Example:\n  cairn eval trajectory out/street/trajectory.tum out/street/truth.tum");
  trajectory->callback([&run, options] { run = [options] { return eval_trajectory(*options); }; });

  CLI::App* stereo = command->add_subcommand("stereo", "bad pixels, density, errors");
  stereo->add_option("disparity", options->estimate, "16-bit PNG: disparity x 256, 0 = no answer")
      ->required();
  stereo->add_option("truth", options->truth, "the same, 0 = unknown")->required();
  stereo->add_option("--mask", options->mask, "PNG: 255 = evaluate");
  stereo->add_flag("--json", options->json, "print JSON instead of words");
  stereo->footer("Example:\n  cairn eval stereo disparity.png truth.png");
  stereo->callback([&run, options] { run = [options] { return eval_stereo(*options); }; });

  CLI::App* map = command->add_subcommand("map", "how far two maps of one place agree");
  map->add_option("map", options->estimate, "map file")->required();
  map->add_option("reference", options->truth, "map file to compare it with")->required();
  map->add_option("--tolerance", options->tolerance_m, "how far apart is near [m]")
      ->check(CLI::Range(0.001, 1.0))
      ->capture_default_str();
  map->add_flag("--as-they-lie", options->as_they_lie,
                "compare them in their own frames, where else the trajectory.tum beside each lays "
                "one over the other");
  map->add_flag("--json", options->json, "print JSON instead of words");
  map->footer("Example:\n  cairn eval map out/replay/map.cairn out/demo/map.cairn");
  map->callback([&run, options] { run = [options] { return eval_map(*options); }; });
}

}  // namespace cairn::cli
