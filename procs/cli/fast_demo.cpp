// SPDX-License-Identifier: Apache-2.0
#include "bus/stop_signal.hpp"
#include "motor/memory_link.hpp"
#include "procs/cli/demo_run.hpp"
#include "procs/cli/demo_watch.hpp"
#include "procs/cli/lockstep_group.hpp"
#include "procs/cli/progress_line.hpp"
#include "procs/cli/run_processes.hpp"

namespace cairn::cli {
namespace {

/// The nodes of a fast demo, and one that watches them.
class FastGroup {
 public:
  FastGroup(const DemoPlan& plan, SimulatedPlace& place)
      : plan_{plan}, place_{place}, group_{plan.run} {}

  Result<void> build() {
    auto [controller_end, motor_end] =
        motor::make_memory_links([this] { return group_.clock().now_us(); });
    const auto simulator = group_.add<SimulatorNode>([&](const auto& config, bus::Node& node) {
      return SimulatorNode::create_for_lockstep(config, node, std::move(controller_end));
    });
    if (!simulator) return tl::make_unexpected(simulator.error());
    simulator_ = *simulator;
    const auto motor = group_.add<MotorNode>([&](const auto& config, bus::Node& node) {
      return MotorNode::create(config, node, motor::open_once(std::move(motor_end)));
    });
    if (!motor) return tl::make_unexpected(motor.error());
    if (auto added = group_.add<GuardNode>(); !added) return tl::make_unexpected(added.error());
    if (auto added = group_.add<LocalizerNode>(); !added) return tl::make_unexpected(added.error());
    if (auto added = group_.add<MapperNode>(); !added) return tl::make_unexpected(added.error());
    if (auto added = group_.add<PlannerNode>(); !added) return tl::make_unexpected(added.error());
    auto watch = DemoWatch::create(plan_, place_, group_.add_node("demo"));
    if (!watch) return tl::make_unexpected(watch.error());
    watch_ = std::move(*watch);
    return {};
  }

  Result<RunResults> run() {
    bus::StopSignal stop;
    const bus::SteadyClock clock;
    const HostTime begin_us = clock.now_us();
    ProgressLine line;
    auto ran = group_.run(*simulator_, [&] {
      watch_->update();
      if (line.due(clock.now_us())) line.show(watch_->progress(), clock.now_us());
      return !stop.arrived() && !watch_->end();
    });
    if (!ran) return tl::make_unexpected(ran.error());
    RunEnd end;
    end.reason = "stopped by hand";
    if (watch_->end()) end = *watch_->end();
    end.mode = "fast";
    end.realtime_factor = static_cast<double>(watch_->recorder().duration_us()) /
                          static_cast<double>(std::max<HostTime>(clock.now_us() - begin_us, 1));
    return write_results(plan_.run, watch_->recorder(), end, watch_->truth());
  }

 private:
  const DemoPlan& plan_;
  SimulatedPlace& place_;
  LockstepGroup group_;
  bus::Node* simulator_ = nullptr;
  std::unique_ptr<DemoWatch> watch_;
};

}  // namespace

Result<RunResults> run_fast_demo(const DemoPlan& plan, SimulatedPlace& place) {
  FastGroup group(plan, place);
  if (auto built = group.build(); !built) return tl::make_unexpected(built.error());
  return group.run();
}

}  // namespace cairn::cli
