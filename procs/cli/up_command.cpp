// SPDX-License-Identifier: Apache-2.0
#include <spdlog/spdlog.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <iostream>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bus/stop_signal.hpp"
#include "core/start_program.hpp"
#include "procs/cli/command.hpp"
#include "procs/cli/group_plan.hpp"
#include "procs/cli/group_session.hpp"
#include "procs/cli/kept_supervisor.hpp"
#include "procs/cli/output_lines.hpp"
#include "procs/cli/run_folder.hpp"
#include "procs/supervisor/group_memory.hpp"
#include "procs/supervisor/running_program.hpp"

namespace cairn::cli {
namespace {

namespace fs = std::filesystem;

/// Nothing has changed for so long, and nothing is starting: it stays as it is.
constexpr std::int64_t kSettled_us = 6 * kMicrosecondsPerSecond;
constexpr std::int64_t kLongestUp_us = 60 * kMicrosecondsPerSecond;
constexpr std::int64_t kSpin_us = 50'000;
constexpr std::size_t kLastWords = 3;

struct Options {
  GroupPlan plan;
  bool foreground = false;
};

/// What `up` has started, until it is ready.
class Arrival {
 public:
  Arrival(GroupSession& session, fs::path run) : session_{session}, run_{std::move(run)} {}

  /// True once the group is ready, or will not be.
  bool look() {
    const GroupClient& group = session_.group();
    if (group.ready()) return true;
    const HostTime now_us = session_.node().host_time();
    if (begin_us_ == 0) begin_us_ = now_us;
    auto lacking = names(group.lacking());
    if (lacking != lacking_) {
      lacking_ = std::move(lacking);
      changed_us_ = now_us;
    }
    const bool settled =
        group.state() != nullptr && !any_starting() && now_us - changed_us_ > kSettled_us;
    return settled || now_us - begin_us_ > kLongestUp_us;
  }

  int say() {
    const GroupClient& group = session_.group();
    if (group.ready()) {
      const auto running =
          std::count_if(group.state()->processes.begin(), group.state()->processes.end(),
                        [](const auto& process) { return process.pid != 0; });
      std::cerr << "ready: " << running << " processes; run folder " << run_.string()
                << "\n./cairn ps shows them, ./cairn down ends them\n";
      return 0;
    }
    std::cerr << "not ready:\n";
    for (const std::string& one : group.lacking()) {
      std::cerr << "  " << one << "\n";
      const std::string process = one.substr(0, one.find(':'));
      for (const std::string& line : last_lines(run_ / "log" / (process + ".log"), kLastWords)) {
        std::cerr << "    | " << line << "\n";
      }
    }
    std::cerr << "the others run on; ./cairn down ends them. Run folder " << run_.string() << "\n";
    return kExitFailure;
  }

 private:
  static std::vector<std::string> names(std::vector<std::string> lacking) {
    for (std::string& one : lacking) one.resize(one.find(':'));
    return lacking;
  }

  bool any_starting() const {
    const auto& processes = session_.group().state()->processes;
    return std::any_of(processes.begin(), processes.end(), [](const process_state_t& process) {
      const bool is_to_start = process.wanted &&
                               process.actual == process_state_t::ACTUAL_STOPPED &&
                               !process.reason.starts_with("waits for");
      return is_to_start || process.actual == process_state_t::ACTUAL_STARTING;
    });
  }

  GroupSession& session_;
  fs::path run_;
  HostTime begin_us_ = 0;
  HostTime changed_us_ = 0;
  std::vector<std::string> lacking_;
};

// The run's folder, ready for a supervisor; of processes that run without one, as it is.
Result<fs::path> prepare(Options& options, const GroupConfig& group) {
  if (!options.plan.run.empty() && use_of(options.plan.run) == RunUse::kUnsupervised) {
    std::cerr << "the processes of this run still run; they are taken up as they are\n";
    return fs::absolute(options.plan.run);
  }
  if (options.plan.run.empty()) {
    const auto made = make_run_folder();
    if (!made) return made;
    options.plan.run = *made;
  }
  const auto folder = RunFolder::take(
      options.plan.run,
      std::array<fs::path, 3>{options.plan.map, options.plan.group, options.plan.robot});
  if (!folder) return tl::make_unexpected(folder.error());
  if (auto written = write_group(group, options.plan.run); !written) {
    return tl::make_unexpected(written.error());
  }
  return fs::absolute(options.plan.run);
}

void say_changes(const GroupClient& group, std::map<std::string, std::int32_t>& restarts) {
  for (const auto& [process, count] : group.restarts()) {
    if (count > restarts[process]) std::cerr << process << " was started again\n";
    restarts[process] = count;
  }
}

int stay(GroupSession& session, const fs::path& run, bus::StopSignal& stop) {
  auto kept = KeptSupervisor::start(run, session.node().host_time());
  if (!kept) return failed(kept.error().message);
  Arrival arrival(session, run);
  std::optional<int> said;
  int supervisors = 0;
  std::map<std::string, std::int32_t> restarts = session.group().restarts();
  while (!kept->ended()) {
    session.node().spin_once(kSpin_us);
    if (stop.arrived()) kept->end();
    if (auto looked = kept->look_after(session.node().host_time()); !looked) {
      return failed(looked.error().message);
    }
    if (!said && arrival.look()) said = arrival.say();
    say_changes(session.group(), restarts);
    if (kept->restarts() > supervisors) std::cerr << "supervisor was started again\n";
    supervisors = kept->restarts();
  }
  return said.value_or(kExitFailure);
}

// The keeper goes on when this command has returned.
int leave(GroupSession& session, const fs::path& run) {
  std::error_code error;
  fs::create_directories(run / "log", error);
  Program program;
  program.command = {program_folder() / "cairn-cli", "keep", run};
  program.output = run / "log" / "keeper.log";
  auto keeper = RunningProgram::start(program, [](ProgramId) { return Result<void>{}; });
  if (!keeper) return failed(keeper.error().message);
  Arrival arrival(session, run);
  while (!arrival.look()) {
    session.node().spin_once(kSpin_us);
    if (!keeper->end()) continue;
    const auto said = last_lines(run / "log" / "keeper.log", 1);
    return failed(said.empty() ? "the supervisor did not stay; see " + (run / "log").string()
                               : said.back());
  }
  return arrival.say();
}

int up(Options& options) {
  const auto wrong_usage = [](const Error& error) {
    failed(error.message);
    return kExitUsage;
  };
  const auto group = make_group(options.plan);
  if (!group) return wrong_usage(group.error());
  if (auto good = check_processes(*group, options.plan.run); !good) {
    return wrong_usage(good.error());
  }
  std::optional<bus::StopSignal> stop;
  if (options.foreground) stop.emplace();
  const auto run = prepare(options, *group);
  if (!run) return failed(run.error().message);
  const auto as_it_runs = load_group(*run / "group.yaml");
  if (!as_it_runs) return failed(as_it_runs.error().message);
  const auto session = GroupSession::open(as_it_runs->lcm_url);
  if (!session) return failed(session.error().message);
  return stop ? stay(**session, *run, *stop) : leave(**session, *run);
}

}  // namespace

void add_up(CLI::App& app, Run& run) {
  auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand("up", "start a process group; returns when it is ready");
  command->add_option("group", options->plan.group, "group file, as those in config/groups")
      ->required()
      ->type_name("GROUP.yaml");
  command->add_flag("--foreground", options->foreground, "stay; Ctrl-C ends the group");
  command->add_option("--map", options->plan.map, "map file to begin with; default: an empty map");
  command->add_flag("--localize-only", options->plan.localize_only,
                    "the robot finds its way by the map and does not change it");
  command->add_option("--out", options->plan.run,
                      "folder of the run: state and logs; default logs/run-DATE-XXXXXX");
  command->add_option("--robot", options->plan.robot, "robot file in place of the group's");
  command->add_option("--set", options->plan.settings, "PROCESS.KEY=VALUE, wins over all files")
      ->allow_extra_args(false);
  command->add_option("--without", options->plan.without, "a process that is not started with it")
      ->allow_extra_args(false);
  command->add_option("--lcm-url", options->plan.lcm_url, "bus of the group");
  command->footer("Example:\n  cairn up config/groups/simulation.yaml --out logs/hall");
  command->callback([&run, options] { run = [options] { return up(*options); }; });
}

// For `up` alone, which starts it: not a word for people.
void add_keep(CLI::App& app, Run& run) {
  auto folder = std::make_shared<std::string>();
  CLI::App* command = app.add_subcommand("keep", "")->group("");
  command->add_option("run", *folder)->required();
  command->callback([&run, folder] {
    run = [folder] {
      const auto kept = keep_supervisor(*folder);
      return kept ? 0 : failed(kept.error().message);
    };
  });
}

}  // namespace cairn::cli
