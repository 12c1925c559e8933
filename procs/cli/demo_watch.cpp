// SPDX-License-Identifier: Apache-2.0
#include "procs/cli/demo_watch.hpp"

#include <cstdio>

namespace cairn::cli {
namespace {

constexpr std::int64_t kGoal = 1;

}  // namespace

Result<std::unique_ptr<DemoWatch>> DemoWatch::create(const DemoPlan& plan, SimulatedPlace& place,
                                                     bus::Node& node) {
  auto recorder = RunRecorder::create(node, plan.run.out / "recording.lcmlog", plan.run.record_all);
  if (!recorder) return tl::make_unexpected(recorder.error());
  return std::make_unique<DemoWatch>(plan, place, node, std::move(*recorder));
}

DemoWatch::DemoWatch(const DemoPlan& plan, SimulatedPlace& place, bus::Node& node,
                     std::unique_ptr<RunRecorder> recorder)
    : plan_{plan}, place_{place}, recorder_{std::move(recorder)}, order_{node, kGoal} {}

void DemoWatch::update() {
  const evaluation::Trajectory& truth = recorder_->truth();
  for (; visited_ < truth.size(); ++visited_) {
    place_.visit(truth[visited_].T);
    if (visited_ > 0)
      way_m_ += (truth[visited_].T.translation() - truth[visited_ - 1].T.translation()).norm();
  }
}

std::optional<RunEnd> DemoWatch::end() const {
  RunEnd end;
  if (order_.end()) {
    end.finished = order_.end()->explored;
    end.reason = order_.end()->reason;
    return end;
  }
  if (recorder_->set_back()) {
    end.reason = "the simulator was started again, and the place with it";
    return end;
  }
  if (static_cast<double>(recorder_->duration_us()) >= 1e6 * plan_.time_limit_s) {
    end.reason = "stopped at the time limit";
    return end;
  }
  return std::nullopt;
}

std::string DemoWatch::progress() const {
  char figures[80];
  const double time_s = 1e-6 * static_cast<double>(recorder_->duration_us());
  if (visited_ > 0) {
    std::snprintf(figures, sizeof(figures), "%4.0f s  %3.0f %% seen  %5.1f m  ", time_s,
                  100 * place_.coverage(), way_m_);
  } else {
    std::snprintf(figures, sizeof(figures), "%4.0f s  ", time_s);
  }
  return figures + (order_.now().empty() ? "waiting for the planner" : order_.now());
}

RunTruth DemoWatch::truth() const {
  RunTruth truth;
  truth.T_truth_body = recorder_->truth();
  if (truth.T_truth_body.empty()) return truth;
  truth.coverage = place_.coverage();
  truth.score_map = [this](const mapping::VoxelMap& map, const Isometry& T_truth_map) {
    return place_.score(map, T_truth_map, recorder_->truth());
  };
  return truth;
}

}  // namespace cairn::cli
