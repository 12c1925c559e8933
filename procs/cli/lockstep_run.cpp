// SPDX-License-Identifier: Apache-2.0
#include "procs/cli/lockstep_run.hpp"

#include <unistd.h>

#include <cstdio>
#include <memory>

#include "bus/lockstep.hpp"
#include "bus/process.hpp"
#include "bus/stop_signal.hpp"
#include "camera/frame_source.hpp"
#include "procs/camera/camera_node.hpp"
#include "procs/cli/recording_player.hpp"
#include "procs/cli/truth.hpp"
#include "procs/cli/truth_poses.hpp"
#include "procs/mapper/mapper_node.hpp"
#include "procs/odometry/odometry_node.hpp"
#include "procs/stereo/stereo_node.hpp"

namespace cairn::cli {
namespace {

/// The nodes of a run; each is built on a node of the lockstep.
class Group {
 public:
  explicit Group(const RunPlan& plan) : plan_{plan}, lockstep_{plan.threads} {}

  Result<void> build() {
    if (auto built = build_source(); !built) return built;
    if (auto built = build_process(stereo_); !built) return built;
    if (auto built = build_process(odometry_); !built) return built;
    if (auto built = build_process(mapper_); !built) return built;
    if (plan_.truth_poses) {
      if (auto built = build_truth_poses(); !built) return built;
    }
    auto recorder = RunRecorder::create(lockstep_.add("recorder", {}),
                                        plan_.out / "recording.lcmlog", plan_.record_all);
    if (!recorder) return tl::make_unexpected(recorder.error());
    recorder_ = std::move(*recorder);
    return {};
  }

  /// False if it was stopped before the recording's end.
  Result<bool> run() {
    bus::StopSignal stop;
    const bool show_progress = ::isatty(STDERR_FILENO) != 0;
    std::int64_t shown = 0;
    lockstep_.run(*source_node_, [&] {
      if (show_progress && recorder_->frames() != shown) {
        shown = recorder_->frames();
        std::fprintf(stderr, "\rframe %lld", static_cast<long long>(shown));
      }
      return !stop.arrived();
    });
    if (show_progress) std::fprintf(stderr, "\r\033[K");
    if (auto finished = mapper_->finish(); !finished) return tl::make_unexpected(finished.error());
    return source_node_->stopping();
  }

  [[nodiscard]] const RunRecorder& recorder() const { return *recorder_; }

 private:
  Result<bus::Node*> add_node(const std::string& process) {
    auto state = StateFolder::open(state_of(plan_, process));
    if (!state) return tl::make_unexpected(state.error());
    return &lockstep_.add(process, std::move(*state));
  }

  template <class ProcessNode>
  Result<void> build_process(std::unique_ptr<ProcessNode>& process) {
    const auto config = load_config<typename ProcessNode::Config>(
        config_of(plan_, ProcessNode::kName), ProcessNode::kName, bus::kConfigSections);
    if (!config) return tl::make_unexpected(config.error());
    const auto node = add_node(ProcessNode::kName);
    if (!node) return tl::make_unexpected(node.error());
    auto created = ProcessNode::create(*config, **node);
    if (!created) return tl::make_unexpected(created.error());
    process = std::move(*created);
    if constexpr (std::is_same_v<ProcessNode, CameraNode>) source_node_ = *node;
    return {};
  }

  Result<void> build_source() {
    if (plan_.source_is_dataset) return build_process(camera_);
    bus::Bus* bus = nullptr;
    source_node_ = &lockstep_.add("replay", {}, &bus);
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
    truth_poses_ =
        std::make_unique<TruthPoses>(std::move(*truth), lockstep_.add("truth_poses", {}));
    return {};
  }

  const RunPlan& plan_;
  bus::Lockstep lockstep_;
  bus::Node* source_node_ = nullptr;
  std::unique_ptr<CameraNode> camera_;
  std::unique_ptr<RecordingPlayer> player_;
  std::unique_ptr<StereoNode> stereo_;
  std::unique_ptr<OdometryNode> odometry_;
  std::unique_ptr<MapperNode> mapper_;
  std::unique_ptr<TruthPoses> truth_poses_;
  std::unique_ptr<RunRecorder> recorder_;
};

}  // namespace

Result<RunResults> run_lockstep(const RunPlan& plan) {
  Group group(plan);
  if (auto built = group.build(); !built) return tl::make_unexpected(built.error());
  const auto finished = group.run();
  if (!finished) return tl::make_unexpected(finished.error());
  const RunEnd end{*finished,
                   *finished ? "the recording is at its end" : "stopped before the recording's end",
                   false, std::nullopt};
  return write_results(plan, group.recorder(), end);
}

}  // namespace cairn::cli
