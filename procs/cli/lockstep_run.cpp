// SPDX-License-Identifier: Apache-2.0
#include "procs/cli/lockstep_run.hpp"

#include <unistd.h>

#include <cstdio>
#include <memory>

#include "bus/stop_signal.hpp"
#include "camera/frame_source.hpp"
#include "procs/cli/lockstep_group.hpp"
#include "procs/cli/recording_player.hpp"
#include "procs/cli/run_processes.hpp"
#include "procs/cli/source_truth.hpp"
#include "procs/cli/truth.hpp"
#include "procs/cli/truth_poses.hpp"

namespace cairn::cli {
namespace {

/// A recording or dataset through the processes that make a map of it.
class ReplayGroup {
 public:
  explicit ReplayGroup(const RunPlan& plan) : plan_{plan}, group_{plan} {}

  Result<void> build() {
    if (auto built = build_source(); !built) return built;
    if (auto added = group_.add<StereoNode>(); !added) return tl::make_unexpected(added.error());
    if (auto added = group_.add<OdometryNode>(); !added) return tl::make_unexpected(added.error());
    if (plan_.localizer) {
      if (auto added = group_.add<LocalizerNode>(); !added)
        return tl::make_unexpected(added.error());
    }
    if (auto added = group_.add<MapperNode>(); !added) return tl::make_unexpected(added.error());
    if (plan_.truth_poses) {
      if (auto built = build_truth_poses(); !built) return built;
    }
    auto recorder = RunRecorder::create(group_.add_node("recorder"), plan_.out / "recording.lcmlog",
                                        plan_.record_all);
    if (!recorder) return tl::make_unexpected(recorder.error());
    recorder_ = std::move(*recorder);
    return {};
  }

  /// False if it was stopped before the recording's end.
  Result<bool> run() {
    bus::StopSignal stop;
    const bool show_progress = ::isatty(STDERR_FILENO) != 0;
    std::int64_t shown = 0;
    auto ran = group_.run(*source_node_, [&] {
      if (show_progress && recorder_->frames() != shown) {
        shown = recorder_->frames();
        std::fprintf(stderr, "\rframe %lld", static_cast<long long>(shown));
      }
      return !stop.arrived();
    });
    if (show_progress) std::fprintf(stderr, "\r\033[K");
    if (!ran) return tl::make_unexpected(ran.error());
    return source_node_->stopping();
  }

  [[nodiscard]] const RunRecorder& recorder() const { return *recorder_; }

 private:
  Result<void> build_source() {
    if (plan_.source_is_dataset) {
      const auto camera = group_.add<CameraNode>();
      if (!camera) return tl::make_unexpected(camera.error());
      source_node_ = *camera;
      return {};
    }
    bus::Bus* bus = nullptr;
    source_node_ = &group_.add_node("replay", &bus);
    auto player = RecordingPlayer::create(plan_.source, plan_.speed, *bus, *source_node_);
    if (!player) return tl::make_unexpected(player.error());
    player_ = std::move(*player);
    return {};
  }

  Result<void> build_truth_poses() {
    const auto dataset = camera::open_dataset(plan_.source.string());
    if (!dataset) return tl::make_unexpected(dataset.error());
    auto truth = read_body_truth(plan_.truth, plan_.truth_format, plan_.truth_frame,
                                 dataset->info.utimes, dataset->frames->rig().T_body_left);
    if (!truth) return tl::make_unexpected(truth.error());
    truth_poses_ = std::make_unique<TruthPoses>(std::move(*truth), group_.add_node("truth_poses"));
    return {};
  }

  const RunPlan& plan_;
  LockstepGroup group_;
  bus::Node* source_node_ = nullptr;
  std::unique_ptr<RecordingPlayer> player_;
  std::unique_ptr<TruthPoses> truth_poses_;
  std::unique_ptr<RunRecorder> recorder_;
};

}  // namespace

Result<RunResults> run_lockstep(const RunPlan& plan) {
  ReplayGroup group(plan);
  if (auto built = group.build(); !built) return tl::make_unexpected(built.error());
  const auto finished = group.run();
  if (!finished) return tl::make_unexpected(finished.error());
  const auto truth = source_truth(plan);
  if (!truth) return tl::make_unexpected(truth.error());
  RunEnd end;
  end.finished = *finished;
  end.reason = *finished ? "the recording is at its end" : "stopped before the recording's end";
  return write_results(plan, group.recorder(), end, *truth);
}

}  // namespace cairn::cli
