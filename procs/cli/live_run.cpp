// SPDX-License-Identifier: Apache-2.0
#include "procs/cli/live_run.hpp"

#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <map>
#include <memory>
#include <random>

#include "bus/process.hpp"
#include "bus/stop_signal.hpp"
#include "core/child_process.hpp"
#include "core/start_program.hpp"
#include "procs/cli/recording_player.hpp"
#include "procs/cli/source_truth.hpp"

namespace cairn::cli {
namespace {

constexpr std::int64_t kSpin_us = 20'000;
constexpr std::int64_t kLongestHeartbeat_us = 1'200'000;
constexpr std::int64_t kLongestStart_us = 30 * kMicrosecondsPerSecond;
constexpr std::int64_t kLongestStop_us = 20 * kMicrosecondsPerSecond;
/// When nothing has come for so long after the last frame, all is worked off.
constexpr std::int64_t kQuiet_us = kMicrosecondsPerSecond;

class LiveGroup {
 public:
  LiveGroup(const RunPlan& plan, bus::Bus& bus, const bus::HostClock& clock, bus::StopSignal& stop)
      : plan_{plan},
        bus_{bus},
        clock_{clock},
        stop_{stop},
        node_("replay", bus, clock, {}, std::random_device{}()) {}

  Result<RunResults> run() {
    auto recorder = RunRecorder::create(node_, plan_.out / "recording.lcmlog", plan_.record_all);
    if (!recorder) return tl::make_unexpected(recorder.error());
    recorder_ = std::move(*recorder);
    if (!node_.wiring()) return tl::make_unexpected(node_.wiring().error());
    if (auto alone = check_alone(); !alone) return tl::make_unexpected(alone.error());
    for (const char* process : {"stereo", "odometry", "localizer", "mapper"}) {
      if (process == std::string_view("localizer") && !plan_.localizer) continue;
      if (auto started = start(process); !started) return tl::make_unexpected(started.error());
    }
    if (auto ready = wait_until_heard(); !ready) return tl::make_unexpected(ready.error());
    if (auto played = play(); !played) return tl::make_unexpected(played.error());
    RunEnd end;
    end.finished = true;
    end.reason = "the recording is at its end";
    end.live = true;
    end.realtime_factor = recorder_->realtime_factor();
    if (stop_.arrived()) {
      end.finished = false;
      end.reason = "stopped before the recording's end";
    } else {
      wait_until_quiet();
    }
    stop();
    const auto truth = source_truth(plan_);
    if (!truth) return tl::make_unexpected(truth.error());
    return write_results(plan_, *recorder_, end, *truth);
  }

 private:
  Result<void> start(const std::string& process) {
    std::vector<std::string> command{program_folder() / ("cairn-" + process), "--lcm-url",
                                     plan_.lcm_url, "--state", state_of(plan_, process)};
    const ConfigSource config = config_of(plan_, process);
    if (!config.file.empty()) command.insert(command.end(), {"--config", config.file});
    for (const std::string& setting : config.overrides)
      command.insert(command.end(), {"--set", setting});
    auto child = ChildProcess::start(command, plan_.out / "log" / (process + ".log"));
    if (!child) return tl::make_unexpected(child.error());
    children_.insert_or_assign(process, std::move(*child));
    return {};
  }

  // A heartbeat is heard within a second where another group is on this bus.
  Result<void> check_alone() {
    const HostTime until_us = clock_.now_us() + kLongestHeartbeat_us;
    while (clock_.now_us() < until_us) node_.spin_once(kSpin_us);
    for (const std::string_view process : bus::kProcesses) {
      if (!recorder_->heard(std::string(process))) continue;
      return fail("another group's " + std::string(process) +
                  " is on this bus already; end it, or choose another port: --lcm-url "
                  "udpm://239.255.76.67:7668?ttl=0");
    }
    return {};
  }

  // Ctrl-C in a terminal ends them too; that is no failure.
  Result<void> any_ended() {
    if (stop_.arrived()) return {};
    for (auto& [process, child] : children_) {
      if (const auto code = child.exit_code(); code && process != "camera") {
        return fail(process + " ended with code " + std::to_string(*code) + "; see " +
                    (plan_.out / "log" / (process + ".log")).string());
      }
    }
    return {};
  }

  Result<void> wait_until_heard() {
    const HostTime deadline_us = clock_.now_us() + kLongestStart_us;
    const auto heard = [&] {
      return std::all_of(children_.begin(), children_.end(),
                         [&](const auto& child) { return recorder_->heard(child.first); });
    };
    while (!heard() && !stop_.arrived()) {
      node_.spin_once(kSpin_us);
      if (auto ended = any_ended(); !ended) return ended;
      if (clock_.now_us() > deadline_us)
        return fail("the processes were started but not heard; see " +
                    (plan_.out / "log").string());
    }
    return {};
  }

  Result<void> play() {
    if (plan_.source_is_dataset) {
      if (auto started = start("camera"); !started) return started;
      std::optional<int> code;
      while (!stop_.arrived() && !(code = children_.at("camera").exit_code())) {
        spin_and_show();
        if (auto ended = any_ended(); !ended) return ended;
      }
      if (!code) return {};
      if (*code != 0) {
        return fail("camera ended with code " + std::to_string(*code) + "; see " +
                    (plan_.out / "log/camera.log").string());
      }
      return {};
    }
    const auto player = RecordingPlayer::create(plan_.source, plan_.speed, bus_, node_);
    if (!player) return tl::make_unexpected(player.error());
    while (!stop_.arrived() && !node_.stopping()) {
      spin_and_show();
      if (auto ended = any_ended(); !ended) return ended;
    }
    return {};
  }

  void spin_and_show() {
    node_.spin_once(kSpin_us);
    if (::isatty(STDERR_FILENO) != 0)
      std::fprintf(stderr, "\rframe %lld", static_cast<long long>(recorder_->frames()));
  }

  void wait_until_quiet() {
    const HostTime begin_us = clock_.now_us();
    while (clock_.now_us() - std::max(begin_us, recorder_->last_result_us()) < kQuiet_us &&
           clock_.now_us() - begin_us < kLongestStop_us) {
      node_.spin_once(kSpin_us);
    }
    if (::isatty(STDERR_FILENO) != 0) std::fprintf(stderr, "\r\033[K");
  }

  void stop() {
    for (auto& [process, child] : children_) child.signal(SIGTERM);
    const HostTime deadline_us = clock_.now_us() + kLongestStop_us;
    const auto all_ended = [&] {
      return std::all_of(children_.begin(), children_.end(),
                         [](auto& child) { return child.second.exit_code().has_value(); });
    };
    while (!all_ended() && clock_.now_us() < deadline_us) node_.spin_once(kSpin_us);
    node_.spin_once(0);
    children_.clear();
  }

  const RunPlan& plan_;
  bus::Bus& bus_;
  const bus::HostClock& clock_;
  bus::StopSignal& stop_;
  bus::Node node_;
  std::unique_ptr<RunRecorder> recorder_;
  std::map<std::string, ChildProcess> children_;
};

}  // namespace

Result<RunResults> run_live(const RunPlan& plan) {
  std::error_code error;
  std::filesystem::create_directories(plan.out / "log", error);
  bus::StopSignal stop;
  const auto bus = bus::open_bus(plan.lcm_url);
  if (!bus) return tl::make_unexpected(bus.error());
  const bus::SteadyClock clock;
  return LiveGroup(plan, **bus, clock, stop).run();
}

}  // namespace cairn::cli
