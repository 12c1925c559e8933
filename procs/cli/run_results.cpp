// SPDX-License-Identifier: Apache-2.0
#include "procs/cli/run_results.hpp"

#include <cmath>
#include <cstdio>
#include <opencv2/imgcodecs.hpp>

#include "bus/channels.hpp"
#include "bus/codec.hpp"
#include "bus/recording.hpp"
#include "camera/frame_source.hpp"
#include "core/atomic_file.hpp"
#include "mapping/map_file.hpp"
#include "mapping/top_down.hpp"
#include "messages/calibration_messages.hpp"
#include "procs/cli/truth.hpp"

namespace cairn::cli {
namespace {

/// A share of a shorter way says nothing.
constexpr double kShortestWay_m = 1;

std::vector<Eigen::Vector3d> positions_of(const evaluation::Trajectory& trajectory) {
  std::vector<Eigen::Vector3d> positions;
  for (const evaluation::StampedPose& pose : trajectory) positions.push_back(pose.T.translation());
  return positions;
}

/// What truth by lines (KITTI) needs: the times of the source's frames, of which some may have been
/// skipped, and where the camera sits.
struct SourceFrames {
  std::vector<Utime> utimes;
  Isometry T_body_left = Isometry::Identity();
};

Result<SourceFrames> frames_of_recording(const std::filesystem::path& recording) {
  auto reader = bus::RecordingReader::open(recording);
  if (!reader) return tl::make_unexpected(reader.error());
  SourceFrames frames;
  while (const auto event = reader->next()) {
    if (event->message.channel == bus::channels::StereoFrame::name) {
      const auto header = bus::peek_header(event->message.bytes);
      if (header) frames.utimes.push_back(header->utime);
    } else if (event->message.channel == bus::channels::Calibration::name) {
      const auto message = bus::decode<rig_calibration_t>(event->message.bytes);
      const auto rig = message ? messages::to_rig(*message) : tl::make_unexpected(message.error());
      if (rig) frames.T_body_left = rig->T_body_left;
    }
  }
  return frames;
}

Result<SourceFrames> frames_of(const RunPlan& plan) {
  if (!plan.source_is_dataset) return frames_of_recording(plan.source);
  auto dataset = camera::open_dataset(plan.source.string());
  if (!dataset) return tl::make_unexpected(dataset.error());
  return SourceFrames{dataset->info.utimes, dataset->frames->rig().T_body_left};
}

Result<evaluation::Trajectory> truth_of(const RunPlan& plan) {
  const auto frames = frames_of(plan);
  if (!frames) return tl::make_unexpected(frames.error());
  return read_body_truth(plan.truth, plan.truth_format, plan.truth_frame, frames->utimes,
                         frames->T_body_left);
}

Result<void> write_map_picture(const RunPlan& plan, const mapping::VoxelMap& map,
                               const evaluation::Trajectory& trajectory,
                               const evaluation::Trajectory& truth) {
  mapping::TopDownOverlay overlay;
  overlay.perceived_path = positions_of(trajectory);
  overlay.true_path = positions_of(truth);
  if (!trajectory.empty()) overlay.T_map_body = trajectory.back().T;
  std::vector<std::uint8_t> png;
  cv::imencode(".png", mapping::render_top_down(map, overlay), png);
  return write_file_atomically(plan.out / "map.png", png);
}

// Copies the map out of the mapper's state folder, draws it, and has it scored.
Result<evaluation::MapReport> write_map(const RunPlan& plan,
                                        const evaluation::Trajectory& trajectory,
                                        const evaluation::Trajectory& truth,
                                        const Isometry& T_truth_map, const ScoreMap& score_map) {
  const std::filesystem::path saved = state_of(plan, "mapper") / "map.cairn";
  if (!std::filesystem::exists(saved)) return evaluation::MapReport{};
  const auto bytes = read_file(saved);
  if (!bytes) return tl::make_unexpected(bytes.error());
  if (auto copied = write_file_atomically(plan.out / "map.cairn", *bytes); !copied) {
    return tl::make_unexpected(copied.error());
  }
  const auto loaded = mapping::decode_map(*bytes, saved, {});
  if (!loaded) return tl::make_unexpected(loaded.error());
  if (auto drawn = write_map_picture(plan, loaded->map, trajectory, truth); !drawn) {
    return tl::make_unexpected(drawn.error());
  }
  evaluation::MapReport report;
  if (score_map) {
    auto scored = score_map(loaded->map, T_truth_map);
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
  report.realtime_factor = end.realtime_factor;
  if (end.latencies_count) {
    report.latency_ms.frame_to_pose = evaluation::percentiles(recorder.frame_to_pose_ms());
    report.latency_ms.frame_to_map = evaluation::percentiles(recorder.frame_to_map_ms());
  }
  report.dropped = recorder.lost();
  report.skipped = recorder.skipped();
  report.restarts = recorder.restarts();
}

void fill(evaluation::TrajectoryReport& report, const evaluation::TrajectoryScore& score) {
  report.length_m = score.length_m;
  report.ate_rmse_m = score.ate_m.rmse;
  report.odometry_ate_rmse_m = score.ate_m.rmse;
  if (score.rpe_1m) report.rpe_1m = score.rpe_1m->translation_rmse_m;
  report.end_error_m = score.end.position_m;
  if (score.length_m >= kShortestWay_m) report.end_error_fraction = score.end.fraction_of_way;
  report.end_yaw_error_rad = score.end.yaw_rad;
}

}  // namespace

Result<RunResults> write_results(const RunPlan& plan, const RunRecorder& recorder,
                                 const RunEnd& end, const ScoreMap& score_map) {
  RunResults results;
  const evaluation::Trajectory& trajectory = recorder.trajectory();
  results.frames = trajectory.size();
  fill(results.report, recorder, end);
  if (trajectory.empty()) {
    results.report.finished = false;
    results.report.reason = "no frame got a pose; see what the processes print";
  }
  if (auto written = evaluation::write_tum(plan.out / "trajectory.tum", trajectory); !written) {
    return tl::make_unexpected(written.error());
  }
  evaluation::Trajectory truth;
  if (!plan.truth.empty() && !trajectory.empty()) {
    auto read = truth_of(plan);
    if (!read) return tl::make_unexpected(read.error());
    truth = std::move(*read);
    if (auto written = evaluation::write_tum(plan.out / "truth.tum", truth); !written) {
      return tl::make_unexpected(written.error());
    }
    auto score = evaluation::score_trajectory(trajectory, truth);
    if (!score) return tl::make_unexpected(score.error());
    // Poses that were the truth itself are no result.
    if (!plan.truth_poses) fill(results.report.trajectory, *score);
    results.score = std::move(*score);
  }
  auto map =
      write_map(plan, trajectory, truth,
                results.score ? results.score->T_truth_estimate : Isometry::Identity(), score_map);
  if (!map) return tl::make_unexpected(map.error());
  results.report.map = *map;
  if (auto written = evaluation::write_report(plan.out / "report.json", results.report); !written) {
    return tl::make_unexpected(written.error());
  }
  return results;
}

void print_results(const RunPlan& plan, const RunResults& results, bool json) {
  if (json) {
    std::printf("%s\n", evaluation::to_json(results.report).dump(2).c_str());
    return;
  }
  std::printf("%zu frames; %s\n", results.frames, results.report.reason.c_str());
  if (plan.truth_poses) std::printf("the poses were the truth's\n");
  if (results.score && !plan.truth_poses) {
    const evaluation::TrajectoryScore& score = *results.score;
    std::printf("way %.2f m, end point off by %.3f m", score.length_m, score.end.position_m);
    if (score.end.fraction_of_way && score.length_m >= kShortestWay_m) {
      std::printf(" (%.2f %% of the way)", 100 * *score.end.fraction_of_way);
    }
    std::printf(", yaw off by %.2f degrees, ATE %.3f m\n", score.end.yaw_rad * 180 / M_PI,
                score.ate_m.rmse);
  }
  const evaluation::MapReport& map = results.report.map;
  if (map.precision && map.recall && map.tolerance_m) {
    std::printf(
        "map of %.0f mm voxels: %.1f %% of what it holds is true, %.1f %% of what was in view is "
        "in it (within %.0f mm)\n",
        1000 * map.resolution_m.value_or(0), 100 * *map.precision, 100 * *map.recall,
        1000 * *map.tolerance_m);
  }
  const auto print_counts = [](const char* what,
                               const std::optional<std::map<std::string, std::uint64_t>>& counts) {
    if (!counts) return;
    for (const auto& [name, count] : *counts) {
      if (count > 0)
        std::printf("%s: %s %llu\n", what, name.c_str(), static_cast<unsigned long long>(count));
    }
  };
  print_counts("lost in transport", results.report.dropped);
  print_counts("skipped for newer ones", results.report.skipped);
  print_counts("restarted", results.report.restarts);
  std::printf("results in %s: trajectory.tum, map.cairn, map.png, report.json\n", plan.out.c_str());
}

}  // namespace cairn::cli
