// SPDX-License-Identifier: Apache-2.0
#include "supervisor/supervised_group.hpp"

#include <sys/wait.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <fstream>
#include <sstream>

#include "core/start_program.hpp"
#include "procs/cli/group_plan.hpp"
#include "supervisor/processes_of_run.hpp"

namespace cairn::testing {
namespace {

constexpr const char* kUrl = "udpm://239.255.76.67:7667?ttl=0";
constexpr std::int64_t kSpin_us = 5'000;

}  // namespace

SupervisedGroup::SupervisedGroup(const std::vector<std::string>& processes)
    : session_{cli::GroupSession::open(kUrl).value()} {
  config_.group = "test";
  config_.lcm_url = kUrl;
  for (const std::string& name : processes) {
    GroupProcess process;
    process.name = name;
    process.program = program_folder() / "fake_process";
    config_.processes.push_back(process);
  }
}

SupervisedGroup::~SupervisedGroup() {
  kept_.reset();
  kill_processes_of(run());
}

void SupervisedGroup::start() {
  EXPECT_TRUE(cli::write_group(config_, run()));
  keep_again();
}

void SupervisedGroup::keep_again() {
  auto kept = cli::KeptSupervisor::start(run(), now_us());
  ASSERT_TRUE(kept) << kept.error().message;
  kept_ = std::move(*kept);
}

bool SupervisedGroup::up() {
  start();
  return wait_until([&] { return group().ready(); });
}

void SupervisedGroup::kill_supervisor() {
  ASSERT_GT(kept_->pid(), 1);
  ::kill(kept_->pid(), SIGKILL);
}

void SupervisedGroup::let_supervisor_die() {
  const pid_t pid = kept_->pid();
  ASSERT_GT(pid, 1);
  kept_.reset();
  ::kill(pid, SIGKILL);
  ::waitpid(pid, nullptr, 0);
}

bool SupervisedGroup::wait_until(const std::function<bool()>& so, double longest_s) {
  const HostTime deadline_us = now_us() + static_cast<HostTime>(longest_s * 1e6);
  while (!so()) {
    if (now_us() > deadline_us) return false;
    session_->node().spin_once(kSpin_us);
    if (kept_ && error_) error_ = kept_->look_after(now_us());
  }
  return true;
}

bool SupervisedGroup::down() {
  group().tell(group_command_t::ACTION_END);
  return wait_until([&] { return kept_->ended(); });
}

const process_state_t& SupervisedGroup::process(const std::string& name) {
  static const process_state_t none{};
  const process_state_t* found = group().find(name);
  return found == nullptr ? none : *found;
}

bool SupervisedGroup::runs(const std::string& name) {
  return process(name).actual == process_state_t::ACTUAL_RUNNING;
}

std::string SupervisedGroup::log_of(const std::string& process) const {
  std::ifstream file(run() / "log" / (process + ".log"));
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

std::multiset<pid_t> SupervisedGroup::pids_in_proc() const { return processes_of(run()); }

std::multiset<pid_t> SupervisedGroup::pids_in_proc(const std::string& process) const {
  return processes_with((run() / "state" / process).string() + " ");
}

double percentile(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  const auto index = static_cast<std::size_t>(share * static_cast<double>(values.size() - 1));
  return values.at(index);
}

std::string spread_text(const std::vector<double>& seconds) {
  char text[100];
  std::snprintf(text, sizeof(text), "n %zu, median %.2f, largest %.2f s", seconds.size(),
                percentile(seconds, 0.5), percentile(seconds, 1));
  return text;
}

}  // namespace cairn::testing
