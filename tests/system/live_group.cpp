// SPDX-License-Identifier: Apache-2.0
#include "system/live_group.hpp"

#include <algorithm>
#include <csignal>
#include <fstream>
#include <sstream>

#include "procs/cli/run_plan.hpp"
#include "system/recordings_of_tests.hpp"

namespace cairn::testing {
namespace {

constexpr std::int64_t kSpin_us = 10'000;

}  // namespace

LiveGroup::LiveGroup(const std::filesystem::path& dataset, double speed) {
  cli::RunPlan plan;
  plan.source = dataset;
  plan.speed = speed;
  plan = cli::complete(plan).value();
  for (const char* process : {"camera", "stereo", "odometry", "localizer", "mapper"}) {
    settings_[process] = cli::config_of(plan, process).overrides;
  }
  bus_ = bus::open_bus(kStockUrl).value();
  node_ = std::make_unique<bus::Node>("test", *bus_, clock_, StateFolder{}, 1);
  recorder_ = cli::RunRecorder::create(*node_, {}, false).value();
}

void LiveGroup::start(const std::string& process) {
  std::vector<std::string> command{program("cairn-" + process), "--lcm-url", kStockUrl, "--state",
                                   folder_.path() / process};
  for (const std::string& setting : settings_.at(process))
    command.insert(command.end(), {"--set", setting});
  start(process, command);
}

void LiveGroup::start(const std::string& name, const std::vector<std::string>& command) {
  children_.insert_or_assign(
      name, ChildProcess::start(command, folder_.path() / (name + ".log")).value());
}

void LiveGroup::kill(const std::string& name, int signal) {
  children_.at(name).signal(signal);
  wait(name);
}

int LiveGroup::wait(const std::string& name) {
  listen_until([&] { return children_.at(name).exit_code().has_value(); }, 120);
  return children_.at(name).exit_code().value_or(-1000);
}

bool LiveGroup::listen_until(const std::function<bool()>& so, double longest_s) {
  const HostTime deadline_us = clock_.now_us() + static_cast<HostTime>(longest_s * 1e6);
  while (!so()) {
    if (clock_.now_us() > deadline_us) return false;
    node_->spin_once(kSpin_us);
  }
  return true;
}

bool LiveGroup::listen_until_heard(const std::vector<std::string>& processes) {
  return listen_until([&] {
    return std::all_of(processes.begin(), processes.end(),
                       [&](const auto& name) { return recorder_->heard(name); });
  });
}

void LiveGroup::listen_until_quiet() {
  const HostTime begin_us = clock_.now_us();
  listen_until([&] {
    return clock_.now_us() - std::max(begin_us, recorder_->last_result_us()) > 1'000'000;
  });
}

void LiveGroup::stop() {
  for (const bool own : {true, false}) {
    for (auto& [name, child] : children_) {
      if (settings_.contains(name) == own) child.signal(SIGTERM);
    }
    for (auto& [name, child] : children_) {
      if (settings_.contains(name) == own) wait(name);
    }
    // What was sent last has time to be written.
    listen_until([] { return false; }, 0.2);
  }
}

std::string LiveGroup::output(const std::string& name) const {
  std::ifstream file(folder_.path() / (name + ".log"));
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

}  // namespace cairn::testing
