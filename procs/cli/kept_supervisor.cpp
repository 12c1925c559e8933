// SPDX-License-Identifier: Apache-2.0
#include "procs/cli/kept_supervisor.hpp"

#include <poll.h>

#include <csignal>
#include <fstream>
#include <string>
#include <utility>

#include "bus/host_clock.hpp"
#include "bus/stop_signal.hpp"
#include "procs/cli/output_lines.hpp"
#include "procs/supervisor/group_config.hpp"

namespace cairn::cli {
namespace {

namespace fs = std::filesystem;

constexpr int kLookPeriod_ms = 50;
/// What is told to end sooner may not have got as far as to hear it.
constexpr std::int64_t kTellAgain_us = kMicrosecondsPerSecond;

}  // namespace

KeptSupervisor::KeptSupervisor(fs::path run)
    : run_{std::move(run)}, life_{ProcessLife::Policy{}, ProcessLife::Memory{}} {}

Result<KeptSupervisor> KeptSupervisor::start(const fs::path& run, HostTime now_us) {
  KeptSupervisor kept(fs::weakly_canonical(fs::absolute(run)));
  const auto group = load_group(kept.run_ / "group.yaml");
  if (!group) return tl::make_unexpected(group.error());
  std::error_code error;
  fs::create_directories(kept.run_ / "log", error);
  kept.lcm_url_ = group->lcm_url;
  if (auto started = kept.start_now(now_us); !started) return tl::make_unexpected(started.error());
  return kept;
}

fs::path KeptSupervisor::log() const { return run_ / "log" / "supervisor.log"; }

Result<void> KeptSupervisor::start_now(HostTime now_us) {
  Program program;
  program.command = {program_folder() / "cairn-supervisor",
                     "--lcm-url",
                     lcm_url_,
                     "--set",
                     "group=" + (run_ / "group.yaml").string(),
                     "--set",
                     "run=" + run_.string()};
  program.output = std::ofstream(log(), std::ios::app) ? log() : fs::path("/dev/null");
  auto started = RunningProgram::start(program, [](ProgramId) { return Result<void>{}; });
  if (!started) return tl::make_unexpected(started.error());
  program_ = std::move(*started);
  life_.started(now_us);
  told_us_ = now_us;
  return {};
}

Result<void> KeptSupervisor::look_after(HostTime now_us) {
  if (ended_) return {};
  if (program_) {
    life_.heard(now_us, true, "");
    if (const auto end = program_->end()) {
      program_.reset();
      if (auto taken = take_end(now_us, *end); !taken) return taken;
    } else if (ending_ && now_us - told_us_ >= kTellAgain_us) {
      program_->signal(SIGTERM);
      told_us_ = now_us;
    }
  }
  if (life_.next(now_us) != ProcessLife::Action::kStart || ended_) return {};
  if (auto started = start_now(now_us); !started) {
    life_.could_not_start(now_us, started.error().message);
  }
  return {};
}

Result<void> KeptSupervisor::take_end(HostTime now_us, const RunningProgram::End& end) {
  ended_ = end.exit_code == 0;
  if (ended_) return {};
  life_.ended(now_us, end.exit_code);
  const bool never_was_up = life_.restarts() == 0 && end.exit_code.value_or(0) > 0;
  if (!never_was_up && !life_.memory().failed) return {};
  const auto said = last_lines(log(), 1);
  return fail(!said.empty() && never_was_up
                  ? said.back()
                  : "the supervisor was " + life_.reason(now_us) + "; see " + log().string() +
                        "; its processes run on without it");
}

void KeptSupervisor::end() { ending_ = true; }

Result<void> keep_supervisor(const fs::path& run) {
  bus::StopSignal stop;
  const bus::SteadyClock clock;
  auto kept = KeptSupervisor::start(run, clock.now_us());
  if (!kept) return tl::make_unexpected(kept.error());
  while (!kept->ended()) {
    ::poll(nullptr, 0, kLookPeriod_ms);
    if (stop.arrived()) kept->end();
    if (auto looked = kept->look_after(clock.now_us()); !looked) return looked;
  }
  return {};
}

}  // namespace cairn::cli
