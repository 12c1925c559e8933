// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <random>

#include "bus/process.hpp"
#include "bus/stop_signal.hpp"
#include "procs/cli/demo_run.hpp"
#include "procs/cli/demo_watch.hpp"
#include "procs/cli/group_client.hpp"
#include "procs/cli/group_plan.hpp"
#include "procs/cli/kept_supervisor.hpp"
#include "procs/cli/progress_line.hpp"
#include "procs/cli/shared_files.hpp"

namespace cairn::cli {
namespace {

constexpr std::int64_t kSpin_us = 20'000;
constexpr std::int64_t kLookAfter_us = 100'000;
constexpr std::int64_t kLongestHeartbeat_us = 1'200'000;
constexpr std::int64_t kLongestStart_us = 60 * kMicrosecondsPerSecond;
constexpr std::int64_t kLongestEnd_us = 30 * kMicrosecondsPerSecond;

/// The group under its supervisor, and one that watches it.
class LiveDemo {
 public:
  LiveDemo(const DemoPlan& plan, SimulatedPlace& place, bus::Bus& bus, bus::StopSignal& stop)
      : plan_{plan},
        stop_{stop},
        place_{place},
        node_("demo", bus, clock_, {}, std::random_device{}()),
        group_{node_} {}

  Result<RunResults> run() {
    auto watch = DemoWatch::create(plan_, place_, node_);
    if (!watch) return tl::make_unexpected(watch.error());
    watch_ = std::move(*watch);
    if (!node_.wiring()) return tl::make_unexpected(node_.wiring().error());
    if (auto alone = check_alone(); !alone) return tl::make_unexpected(alone.error());
    auto supervisor = KeptSupervisor::start(plan_.run.out, clock_.now_us());
    if (!supervisor) return tl::make_unexpected(supervisor.error());
    supervisor_.emplace(std::move(*supervisor));
    const auto end = watch_until_over();
    auto ended = end_group();
    if (!end) return tl::make_unexpected(end.error());
    if (!ended) return tl::make_unexpected(ended.error());
    if (watch_->recorder().missed() > 0) {
      std::fprintf(stderr, "recording.lcmlog lacks %lld messages that did not reach the recorder\n",
                   static_cast<long long>(watch_->recorder().missed()));
    }
    return write_results(plan_.run, watch_->recorder(), *end, watch_->truth());
  }

 private:
  // A heartbeat is heard within a second where another group is on this bus.
  Result<void> check_alone() {
    const HostTime until_us = clock_.now_us() + kLongestHeartbeat_us;
    while (clock_.now_us() < until_us) node_.spin_once(kSpin_us);
    for (const std::string_view process : bus::kProcesses) {
      if (!watch_->recorder().heard(std::string(process))) continue;
      return fail("another group's " + std::string(process) +
                  " is on this bus already; end it (cairn down), or choose another port: "
                  "--lcm-url udpm://239.255.76.67:7668?ttl=0");
    }
    return {};
  }

  // An error: the group did not come up.
  Result<RunEnd> watch_until_over() {
    const HostTime deadline_us = clock_.now_us() + kLongestStart_us;
    bool came_up = false;
    ProgressLine line;
    RunEnd end;
    while (!stop_.arrived()) {
      if (auto kept = spin(); !kept) return tl::make_unexpected(kept.error());
      watch_->update();
      came_up = came_up || group_.ready();
      if (!came_up && clock_.now_us() > deadline_us)
        return fail("the group did not come up: " + trouble());
      if (line.due(clock_.now_us())) line.show(progress(), clock_.now_us());
      if (auto over = watch_->end()) return with_counts(*over);
      if (supervisor_->ended()) return with_counts(because("somebody ended the group"));
      if (auto lost = given_up(); !lost.empty()) return with_counts(because(lost));
    }
    return with_counts(because("stopped by hand"));
  }

  Result<void> spin() {
    node_.spin_once(kSpin_us);
    if (clock_.now_us() - looked_after_us_ < kLookAfter_us) return {};
    looked_after_us_ = clock_.now_us();
    return supervisor_->look_after(looked_after_us_);
  }

  Result<void> end_group() {
    supervisor_->end();
    const HostTime deadline_us = clock_.now_us() + kLongestEnd_us;
    while (!supervisor_->ended()) {
      if (auto kept = spin(); !kept) return kept;
      if (clock_.now_us() > deadline_us)
        return fail("the group did not end; see " + (plan_.run.out / "log").string());
    }
    node_.spin_once(0);
    return {};
  }

  [[nodiscard]] std::string trouble() const {
    if (group_.state() == nullptr) return "nothing is heard of the supervisor";
    std::string words;
    for (const std::string& lacking : group_.lacking())
      words += (words.empty() ? "" : "; ") + lacking;
    return words;
  }

  [[nodiscard]] std::string progress() const {
    const std::string lacking = trouble();
    return watch_->progress() + (lacking.empty() ? "" : "  [" + lacking + "]");
  }

  [[nodiscard]] std::string given_up() const {
    if (group_.state() == nullptr) return "";
    for (const process_state_t& process : group_.state()->processes) {
      if (process.actual == process_state_t::ACTUAL_FAILED)
        return process.process + " was given up: " + process.reason;
    }
    return "";
  }

  static RunEnd because(const std::string& reason) {
    RunEnd end;
    end.reason = reason;
    return end;
  }

  [[nodiscard]] RunEnd with_counts(RunEnd end) const {
    end.live = true;
    end.realtime_factor = watch_->recorder().realtime_factor();
    for (const auto& [process, count] : group_.restarts())
      end.restarts[process] = static_cast<std::uint64_t>(count);
    end.restarts["supervisor"] = static_cast<std::uint64_t>(supervisor_->restarts());
    return end;
  }

  const DemoPlan& plan_;
  bus::StopSignal& stop_;
  bus::SteadyClock clock_;
  SimulatedPlace& place_;
  bus::Node node_;
  GroupClient group_;
  std::unique_ptr<DemoWatch> watch_;
  std::optional<KeptSupervisor> supervisor_;
  HostTime looked_after_us_ = 0;
};

}  // namespace

Result<GroupConfig> demo_group(const DemoPlan& plan) {
  GroupPlan group;
  group.group = shared_file("config/groups/simulation.yaml");
  group.run = plan.run.out;
  group.settings = plan.run.implied;
  group.settings.insert(group.settings.end(), plan.run.settings.begin(), plan.run.settings.end());
  group.robot = plan.run.config_file;
  group.lcm_url = plan.run.lcm_url;
  return make_group(group);
}

Result<RunResults> run_live_demo(const DemoPlan& plan, const GroupConfig& group,
                                 SimulatedPlace& place) {
  if (auto written = write_group(group, plan.run.out); !written)
    return tl::make_unexpected(written.error());
  bus::StopSignal stop;
  const auto bus = bus::open_bus(plan.run.lcm_url);
  if (!bus) return tl::make_unexpected(bus.error());
  return LiveDemo(plan, place, **bus, stop).run();
}

}  // namespace cairn::cli
