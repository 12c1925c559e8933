// SPDX-License-Identifier: Apache-2.0
#include "procs/supervisor/supervisor_node.hpp"

#include <unistd.h>

#include <algorithm>
#include <cairn/log_line_t.hpp>
#include <csignal>
#include <fstream>
#include <utility>

#include "bus/log_format.hpp"
#include "bus/process.hpp"

namespace cairn {
namespace {

namespace channels = bus::channels;
namespace fs = std::filesystem;
using Action = ProcessLife::Action;

constexpr std::int64_t kLookPeriod_us = 20'000;
constexpr std::int64_t kOutputPeriod_us = 100'000;
/// Not looked for so long: nobody has listened to heartbeats meanwhile.
constexpr std::int64_t kLongestLook_us = 200'000;
/// In this time everybody who is on the bus has sent a heartbeat.
constexpr std::int64_t kListen_us = 1'200'000;
constexpr std::int64_t kStrangerGone_us = 3 * kMicrosecondsPerSecond;
constexpr std::int64_t kOldestCommand_us = 5 * kMicrosecondsPerSecond;
/// Time for the kernel to end what was killed.
constexpr std::int64_t kKilled_us = 5 * kMicrosecondsPerSecond;
/// Of each process; a heartbeat of one may still be under way when the next has started.
constexpr std::size_t kFormerRuns = 64;
constexpr std::size_t kCommanders = 256;
constexpr const char* kOwnLine = "supervisor: ";

std::string note_of(const process_status_t& status) {
  if (status.health == process_status_t::HEALTH_ILL) return "ill: " + status.reason;
  if (status.health == process_status_t::HEALTH_WAITING) return "waiting: " + status.reason;
  return status.reason;
}

std::int8_t message_state(ProcessLife::State state) {
  switch (state) {
    case ProcessLife::State::kStarting:
      return process_state_t::ACTUAL_STARTING;
    case ProcessLife::State::kRunning:
      return process_state_t::ACTUAL_RUNNING;
    case ProcessLife::State::kHung:
      return process_state_t::ACTUAL_HUNG;
    case ProcessLife::State::kFailed:
      return process_state_t::ACTUAL_FAILED;
    case ProcessLife::State::kStopped:
      break;
  }
  return process_state_t::ACTUAL_STOPPED;
}

// A log that cannot be written is no reason not to run.
fs::path output_file(const fs::path& log) {
  return std::ofstream(log, std::ios::app) ? log : fs::path("/dev/null");
}

}  // namespace

Result<void> SupervisorNode::check(const Config& config) {
  if (config.group.empty()) return fail("supervisor.group: names no file");
  if (config.run.empty()) return fail("supervisor.run: names no folder");
  const auto group = load_group(config.group);
  return group ? Result<void>{} : tl::make_unexpected(group.error());
}

Result<std::unique_ptr<SupervisorNode>> SupervisorNode::create(const Config& config,
                                                               bus::Node& node) {
  const auto group = load_group(config.group);
  if (!group) return tl::make_unexpected(group.error());
  const std::string ours = bus::effective_url("");
  if (!group->lcm_url.empty() && group->lcm_url != ours) {
    return fail(config.group + ": lcm_url: " + group->lcm_url +
                " is not the bus that this supervisor is on (" + ours + "); give it --lcm-url");
  }
  const fs::path run = fs::weakly_canonical(fs::absolute(config.run));
  std::error_code error;
  fs::create_directories(run / "log", error);
  if (error) return fail((run / "log").string() + ": cannot make the folder: " + error.message());
  auto state = StateFolder::open(supervisor_state(run));
  if (!state) return tl::make_unexpected(state.error());
  const auto memory = recall_group(*state);
  return std::make_unique<SupervisorNode>(*group, run, std::move(*state), memory, node);
}

SupervisorNode::SupervisorNode(const GroupConfig& group, fs::path run, StateFolder state,
                               const std::optional<GroupMemory>& memory, bus::Node& node)
    : group_{group},
      run_{std::move(run)},
      state_{std::move(state)},
      node_{node},
      life_{group, memory.value_or(GroupMemory{})},
      children_(life_.size()),
      listen_until_us_{node.host_time() + kListen_us},
      looked_us_{node.host_time()} {
  for (std::size_t i = 0; i < life_.size(); ++i) {
    children_[i].printed.emplace(run_ / "log" / (life_.name(i) + ".log"));
  }
  if (memory) adopt(*memory);
  node.counter("starts") = starts_;
  remembered_ = remember();
  node.on<channels::ProcessStatus>([this](const process_status_t& status) { take(status); });
  node.on<channels::GroupState>([this](const group_state_t& other) { take(other); });
  node.on<channels::GroupCommand>([this](const group_command_t& command) { take(command); });
  node.every_host(kLookPeriod_us, [this] { look_after(); });
  node.every_host(kOutputPeriod_us, [this] { carry_output(); });
  node.every_host(kMicrosecondsPerSecond, [this] {
    node_.publish<channels::GroupState>(state_message(), node_.data_time());
  });
  if (life_.ending()) node.request_stop();
}

// The bus was found free by the one before.
void SupervisorNode::adopt(const GroupMemory& memory) {
  listen_until_us_ = node_.host_time();
  starts_ = memory.supervisor_starts + 1;
  for (std::size_t i = 0; i < life_.size(); ++i) {
    const auto known = memory.processes.find(life_.name(i));
    if (known == memory.processes.end() || known->second.program.pid == 0) continue;
    children_[i].former.insert(known->second.program.pid);
    children_[i].program = RunningProgram::adopt(known->second.program);
    if (children_[i].program) {
      life_.life(i).adopted(node_.host_time());
      say(i, "taken up (pid " + std::to_string(known->second.program.pid) + ")");
    } else {
      life_.life(i).ended(node_.host_time(), std::nullopt);
      say(i, "ended while nobody watched");
    }
  }
}

void SupervisorNode::look_after() {
  const HostTime now_us = node_.host_time();
  if (now_us - looked_us_ > kLongestLook_us) {
    for (std::size_t i = 0; i < life_.size(); ++i) {
      life_.life(i).nobody_listened(now_us - looked_us_);
    }
  }
  looked_us_ = now_us;
  notice_ends(now_us);
  if (now_us >= listen_until_us_ && bus_is_ours_) act(now_us);
  tell_health();
  publish_changes();
}

void SupervisorNode::notice_ends(HostTime now_us) {
  for (std::size_t i = 0; i < life_.size(); ++i) {
    Child& child = children_[i];
    const auto end = child.program ? child.program->end() : std::nullopt;
    if (!end) continue;
    child.program.reset();
    life_.life(i).ended(now_us, end->exit_code);
    say(i, life_.reason(i, now_us));
    remembered_ = remember();
  }
}

void SupervisorNode::act(HostTime now_us) {
  for (std::size_t i = 0; i < life_.size(); ++i) {
    const std::optional<RunningProgram>& program = children_[i].program;
    switch (life_.next(i, now_us)) {
      case Action::kNone:
        break;
      case Action::kStart:
        start(i, now_us);
        break;
      case Action::kInterrupt:
        program->signal(SIGINT);
        break;
      case Action::kTerminate:
        program->signal(SIGTERM);
        break;
      case Action::kKill:
        say(i, life_.reason(i, now_us) + "; is killed");
        program->signal(SIGKILL);
        break;
    }
  }
}

void SupervisorNode::start(std::size_t process, HostTime now_us) {
  Child& child = children_[process];
  Program program;
  program.command = command_of(group_, life_.config(process), run_);
  program.output = output_file(run_ / "log" / (life_.name(process) + ".log"));
  auto started = RunningProgram::start(program, [&](ProgramId id) {
    GroupMemory with_it = memory();
    with_it.processes[life_.name(process)].program = id;
    ++with_it.processes[life_.name(process)].life.starts;
    return remember_group(state_, with_it);
  });
  if (!started) {
    life_.life(process).could_not_start(now_us, started.error().message);
    return say(process, life_.reason(process, now_us));
  }
  if (child.former.size() > kFormerRuns) child.former.clear();
  child.former.insert(started->id().pid);
  child.program = std::move(*started);
  life_.life(process).started(now_us);
}

// To everybody, and to who reads what the process itself printed.
void SupervisorNode::say(std::size_t process, const std::string& what) {
  const std::string text = life_.name(process) + ": " + what;
  node_.log(bus::Level::kInfo, text);
  std::ofstream(run_ / "log" / (life_.name(process) + ".log"), std::ios::app)
      << kOwnLine << text << "\n";
}

void SupervisorNode::take(const process_status_t& status) {
  const HostTime now_us = node_.host_time();
  for (std::size_t i = 0; i < life_.size(); ++i) {
    if (life_.name(i) != status.process) continue;
    const Child& child = children_[i];
    if (child.program && child.program->owns(status.pid)) {
      life_.life(i).heard(now_us, status.health != process_status_t::HEALTH_STARTING,
                          note_of(status));
      return;
    }
    if (child.former.contains(status.pid)) return;
    strangers_[status.process] = {status.pid, now_us};
  }
  const bool is_robots = std::find(bus::kProcesses.begin(), bus::kProcesses.end(),
                                   status.process) != bus::kProcesses.end();
  if (is_robots || strangers_.contains(status.process)) {
    refuse_bus(status.process + " (pid " + std::to_string(status.pid) + ")");
  }
}

void SupervisorNode::take(const group_state_t& other) {
  if (other.run != run_) refuse_bus("supervisor (" + other.run + ")");
}

// Before anything is started, another group's processes are a reason not to start; later they are
// something to be told of.
void SupervisorNode::refuse_bus(const std::string& who) {
  if (node_.host_time() >= listen_until_us_ || !bus_is_ours_) return;
  bus_is_ours_ = fail("another group's " + who +
                      " is on this bus already; end that group (./cairn down), or choose another "
                      "bus: --lcm-url udpm://239.255.76.67:7668?ttl=0");
  node_.request_stop();
}

void SupervisorNode::take(const group_command_t& command) {
  if (auto obeyed = obey(command); !obeyed) {
    return node_.refuse(channels::GroupCommand::name, obeyed.error().message);
  }
  remembered_ = remember();
  publish_changes();
}

Result<void> SupervisorNode::obey(const group_command_t& command) {
  const HostTime now_us = node_.host_time();
  const std::int64_t age_us = now_us - command.header.sent_steady_us;
  if (age_us < 0 || age_us > kOldestCommand_us) {
    return fail("was not sent within the last 5 s");
  }
  if (last_command_.size() > kCommanders) last_command_.clear();
  const auto [last, fresh] =
      last_command_.try_emplace(command.header.session, command.header.sequence);
  if (!fresh && command.header.sequence <= last->second) return fail("was obeyed before");
  last->second = command.header.sequence;
  switch (command.action) {
    case group_command_t::ACTION_START:
      return life_.wish(GroupLife::Wish::kStart, command.process, now_us);
    case group_command_t::ACTION_STOP:
      return life_.wish(GroupLife::Wish::kStop, command.process, now_us);
    case group_command_t::ACTION_RESTART:
      return life_.wish(GroupLife::Wish::kRestart, command.process, now_us);
    case group_command_t::ACTION_END:
      if (!command.process.empty()) return fail("ACTION_END: is for the whole group");
      life_.end(now_us);
      node_.request_stop();
      return {};
    default:
      return fail("action " + std::to_string(command.action) + " is not known");
  }
}

// What a node logs has been heard already.
void SupervisorNode::carry_output() {
  for (std::size_t i = 0; i < life_.size(); ++i) {
    for (std::string& line : children_[i].printed->take()) {
      if (bus::is_log_line(line) || line.starts_with(kOwnLine) || line.empty()) continue;
      log_line_t message{};
      message.process = life_.name(i);
      message.level = log_line_t::LEVEL_WARNING;
      message.text = std::move(line);
      node_.publish<channels::LogLine>(std::move(message), node_.data_time());
    }
  }
}

void SupervisorNode::publish_changes() {
  group_state_t message = state_message();
  std::vector<std::int64_t> now;
  for (const process_state_t& process : message.processes) {
    now.insert(now.end(), {process.wanted, process.actual, process.pid, process.restarts});
  }
  if (now == published_) return;
  published_ = std::move(now);
  node_.publish<channels::GroupState>(std::move(message), node_.data_time());
}

group_state_t SupervisorNode::state_message() const {
  const HostTime now_us = node_.host_time();
  group_state_t message{};
  message.group = group_.group;
  message.run = run_;
  message.pid = ::getpid();
  for (std::size_t i = 0; i < life_.size(); ++i) {
    const ProcessLife& life = life_.life(i);
    process_state_t process{};
    process.process = life_.name(i);
    process.wanted = life.wanted();
    process.actual = message_state(life.state(now_us));
    process.pid = children_[i].program ? children_[i].program->id().pid : 0;
    process.restarts = life.restarts();
    process.exit_code = life.exit_code();
    process.reason = life_.reason(i, now_us);
    message.processes.push_back(std::move(process));
  }
  message.count = static_cast<std::int32_t>(message.processes.size());
  return message;
}

GroupMemory SupervisorNode::memory() const {
  GroupMemory memory;
  memory.supervisor_starts = starts_;
  memory.ending = life_.ending();
  for (std::size_t i = 0; i < life_.size(); ++i) {
    memory.processes[life_.name(i)] = {
        life_.life(i).memory(), children_[i].program ? children_[i].program->id() : ProgramId{}};
  }
  return memory;
}

Result<void> SupervisorNode::remember() { return remember_group(state_, memory()); }

void SupervisorNode::tell_health() {
  const HostTime now_us = node_.host_time();
  std::erase_if(strangers_, [&](const auto& stranger) {
    return now_us - stranger.second.heard_us > kStrangerGone_us;
  });
  if (!remembered_) {
    node_.set_health(bus::Health::kIll, remembered_.error().message);
  } else if (!strangers_.empty()) {
    const auto& [name, stranger] = *strangers_.begin();
    node_.set_health(bus::Health::kIll, "another " + name + " (pid " +
                                            std::to_string(stranger.pid) + ") is on this bus");
  } else {
    node_.set_health(bus::Health::kOk, "");
  }
}

Result<void> SupervisorNode::finish() {
  if (!bus_is_ours_) return bus_is_ours_;
  life_.end(node_.host_time());
  remembered_ = remember();
  listen_until_us_ = node_.host_time();
  std::int64_t longest_us = kKilled_us;
  for (std::size_t i = 0; i < life_.size(); ++i) {
    const auto grace_us = static_cast<std::int64_t>(1e6 * life_.config(i).stop_grace_s);
    longest_us = std::max(longest_us, grace_us + kKilled_us);
  }
  const HostTime deadline_us = node_.host_time() + longest_us;
  while (!life_.nothing_runs() && node_.host_time() < deadline_us) node_.spin_once(kLookPeriod_us);
  carry_output();
  node_.publish<channels::GroupState>(state_message(), node_.data_time());
  for (std::size_t i = 0; i < life_.size(); ++i) {
    if (!life_.life(i).runs()) continue;
    return fail(life_.name(i) + " (pid " + std::to_string(children_[i].program->id().pid) +
                ") could not be ended");
  }
  return forget_group(state_);
}

}  // namespace cairn
