// SPDX-License-Identifier: Apache-2.0
#include "procs/cli/run_results.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <opencv2/imgcodecs.hpp>

#include "core/atomic_file.hpp"
#include "mapping/map_file.hpp"
#include "mapping/top_down.hpp"

namespace cairn::cli {
namespace {

std::vector<Eigen::Vector3d> positions_of(const evaluation::Trajectory& trajectory) {
  std::vector<Eigen::Vector3d> positions;
  for (const evaluation::StampedPose& pose : trajectory) positions.push_back(pose.T.translation());
  return positions;
}

Result<void> write_map_picture(const RunPlan& plan, const mapping::VoxelMap& map,
                               const evaluation::Trajectory& trajectory,
                               const evaluation::Trajectory& truth,
                               const std::optional<Isometry>& T_truth_map) {
  mapping::TopDownOverlay overlay;
  overlay.perceived_path = positions_of(trajectory);
  if (T_truth_map) {
    const Isometry T_map_truth = T_truth_map->inverse();
    for (const evaluation::StampedPose& pose : truth)
      overlay.true_path.push_back(T_map_truth * pose.T.translation());
    if (!truth.empty()) overlay.T_map_true_body = T_map_truth * truth.back().T;
  }
  if (!trajectory.empty()) overlay.T_map_body = trajectory.back().T;
  std::vector<std::uint8_t> png;
  cv::imencode(".png", mapping::render_top_down(map, overlay), png);
  return write_file_atomically(plan.out / "map.png", png);
}

// Copies the map out of the mapper's state folder, draws it, and has it scored.
Result<evaluation::MapReport> write_map(const RunPlan& plan,
                                        const evaluation::Trajectory& trajectory,
                                        const RunTruth& truth,
                                        const std::optional<Isometry>& T_truth_map) {
  const std::filesystem::path saved = state_of(plan, "mapper") / "map.cairn";
  if (!std::filesystem::exists(saved)) return evaluation::MapReport{};
  const auto bytes = read_file(saved);
  if (!bytes) return tl::make_unexpected(bytes.error());
  if (auto copied = write_file_atomically(plan.out / "map.cairn", *bytes); !copied) {
    return tl::make_unexpected(copied.error());
  }
  const auto loaded = mapping::decode_map(*bytes, saved, {});
  if (!loaded) return tl::make_unexpected(loaded.error());
  if (auto drawn =
          write_map_picture(plan, loaded->map, trajectory, truth.T_truth_body, T_truth_map);
      !drawn) {
    return tl::make_unexpected(drawn.error());
  }
  evaluation::MapReport report;
  if (truth.score_map && T_truth_map) {
    auto scored = truth.score_map(loaded->map, *T_truth_map);
    if (!scored) return scored;
    report = *scored;
  }
  report.resolution_m = loaded->map.resolution_m();
  report.bytes = loaded->map.bytes();
  return report;
}

void fill(evaluation::Report& report, const RunRecorder& recorder, const RunEnd& end) {
  report.finished = end.finished;
  report.reason = end.reason;
  report.mode = end.mode;
  report.realtime_factor = end.realtime_factor;
  report.collisions = recorder.collisions();
  if (end.live) {
    report.cpu_cores = recorder.cpu_cores();
    report.latency_ms.frame_to_pose = evaluation::percentiles(recorder.frame_to_pose_ms());
    report.latency_ms.frame_to_correction =
        evaluation::percentiles(recorder.frame_to_correction_ms());
    report.latency_ms.frame_to_map = evaluation::percentiles(recorder.frame_to_map_ms());
  }
  report.dropped = recorder.lost();
  report.skipped = recorder.skipped();
  report.restarts = recorder.restarts();
  for (const auto& [process, count] : end.restarts) {
    std::uint64_t& heard = (*report.restarts)[process];
    heard = std::max(heard, count);
  }
}

void fill(evaluation::TrajectoryReport& report, const evaluation::TrajectoryScore& score) {
  report.length_m = score.length_m;
  report.ate_rmse_m = score.ate_m.rmse;
  if (score.rpe_1m) report.rpe_1m = score.rpe_1m->translation_rmse_m;
  report.end_error_m = score.end.position_m;
  if (score.length_m >= evaluation::kShortestWay_m)
    report.end_error_fraction = score.end.fraction_of_way;
  report.end_yaw_error_rad = score.end.yaw_rad;
}

std::optional<double> ate_of(const evaluation::Trajectory& estimate,
                             const evaluation::Trajectory& truth) {
  const auto score = evaluation::score_trajectory(estimate, truth);
  if (!score) return std::nullopt;
  return score->ate_m.rmse;
}

Result<void> write_trajectories(const RunPlan& plan, const RunRecorder& recorder,
                                const RunTruth& truth) {
  const auto write = [&](const char* name, const evaluation::Trajectory& trajectory) {
    return evaluation::write_tum(plan.out / name, trajectory);
  };
  if (auto written = write("trajectory.tum", recorder.trajectory()); !written) return written;
  if (auto written = write("trajectory_final.tum", recorder.final_trajectory()); !written)
    return written;
  return truth.T_truth_body.empty() ? Result<void>{} : write("truth.tum", truth.T_truth_body);
}

}  // namespace

Result<RunResults> write_results(const RunPlan& plan, const RunRecorder& recorder,
                                 const RunEnd& end, const RunTruth& truth) {
  RunResults results;
  const evaluation::Trajectory& trajectory = recorder.trajectory();
  results.frames = trajectory.size();
  fill(results.report, recorder, end);
  results.report.coverage = truth.coverage;
  if (trajectory.empty()) {
    results.report.finished = false;
    results.report.reason = "no frame got a pose; see what the processes print";
  }
  if (auto written = write_trajectories(plan, recorder, truth); !written)
    return tl::make_unexpected(written.error());
  if (!truth.T_truth_body.empty() && !trajectory.empty()) {
    auto score = evaluation::score_trajectory(trajectory, truth.T_truth_body);
    if (!score) return tl::make_unexpected(score.error());
    // Poses that were the truth itself are no result.
    if (!plan.truth_poses) {
      fill(results.report.trajectory, *score);
      results.report.trajectory.final_ate_rmse_m =
          ate_of(recorder.final_trajectory(), truth.T_truth_body);
      results.report.trajectory.odometry_ate_rmse_m =
          ate_of(recorder.odometry(), truth.T_truth_body);
    }
    results.score = std::move(*score);
  }
  std::optional<Isometry> T_truth_map;
  if (results.score)
    T_truth_map = evaluation::align_maps(evaluation::associate(trajectory, truth.T_truth_body));
  auto map = write_map(plan, trajectory, truth, T_truth_map);
  if (!map) return tl::make_unexpected(map.error());
  results.report.map = *map;
  if (auto written = evaluation::write_report(plan.out / "report.json", results.report); !written) {
    return tl::make_unexpected(written.error());
  }
  return results;
}

namespace {

void print(const evaluation::TrajectoryScore& score) {
  std::printf("way %.2f m, end point off by %.3f m", score.length_m, score.end.position_m);
  if (score.end.fraction_of_way && score.length_m >= evaluation::kShortestWay_m) {
    std::printf(" (%.2f %% of the way)", 100 * *score.end.fraction_of_way);
  }
  std::printf(", yaw off by %.2f degrees, ATE %.3f m\n", score.end.yaw_rad * 180 / M_PI,
              score.ate_m.rmse);
}

void print(const evaluation::MapReport& map) {
  if (!map.precision || !map.recall || !map.tolerance_m) return;
  std::printf(
      "map of %.0f mm voxels: %.1f %% of what it holds is true, %.1f %% of what was in view is "
      "in it (within %.0f mm)\n",
      1000 * map.resolution_m.value_or(0), 100 * *map.precision, 100 * *map.recall,
      1000 * *map.tolerance_m);
}

void print_load(const evaluation::Report& report) {
  if (report.latency_ms.frame_to_pose && report.latency_ms.frame_to_map) {
    std::printf("from frame to pose %.0f ms, to map %.0f ms (median)\n",
                report.latency_ms.frame_to_pose->p50, report.latency_ms.frame_to_map->p50);
  }
  if (!report.cpu_cores) return;
  std::printf("processor, in %% of a core:");
  for (const auto& [process, cores] : *report.cpu_cores)
    std::printf(" %s %.0f", process.c_str(), 100 * cores);
  std::printf("\n");
}

}  // namespace

void print_results(const RunPlan& plan, const RunResults& results, bool json) {
  const evaluation::Report& report = results.report;
  if (json) {
    std::printf("%s\n", evaluation::to_json(report).dump(2).c_str());
    return;
  }
  if (report.mode == "fast")
    std::printf("FAST: no images; stereo and odometry were a model of their errors\n");
  std::printf("%zu frames; %s\n", results.frames, report.reason.c_str());
  if (report.coverage)
    std::printf("%.1f %% of the floor that can be reached was seen\n", 100 * *report.coverage);
  if (report.collisions)
    std::printf("collisions: %llu\n", static_cast<unsigned long long>(*report.collisions));
  if (plan.truth_poses) std::printf("the poses were the truth's\n");
  if (results.score && !plan.truth_poses) print(*results.score);
  print(report.map);
  if (report.realtime_factor) std::printf("%.2f times life\n", *report.realtime_factor);
  print_load(report);
  const auto print_counts = [](const char* what,
                               const std::optional<std::map<std::string, std::uint64_t>>& counts) {
    if (!counts) return;
    for (const auto& [name, count] : *counts) {
      if (count > 0)
        std::printf("%s: %s %llu\n", what, name.c_str(), static_cast<unsigned long long>(count));
    }
  };
  print_counts("lost in transport", report.dropped);
  print_counts("skipped for newer ones", report.skipped);
  print_counts("restarted", report.restarts);
  std::printf("results in %s: trajectory.tum, map.cairn, map.png, report.json\n", plan.out.c_str());
}

}  // namespace cairn::cli
