// SPDX-License-Identifier: Apache-2.0
#include "procs/cli/group_client.hpp"

#include "procs/supervisor/running_program.hpp"

namespace cairn::cli {
namespace {

namespace channels = bus::channels;

constexpr std::int64_t kSilent_us = 3 * kMicrosecondsPerSecond;
constexpr std::int64_t kSpin_us = 20'000;

std::string state_text(const process_state_t& process) {
  switch (process.actual) {
    case process_state_t::ACTUAL_STARTING:
      return "is starting";
    case process_state_t::ACTUAL_HUNG:
      return "hangs";
    case process_state_t::ACTUAL_FAILED:
      return "failed";
    default:
      return "does not run";
  }
}

}  // namespace

GroupClient::GroupClient(bus::Node& node) : node_{node} {
  node.on<channels::GroupState>([this](const group_state_t& state) {
    state_ = state;
    heard_us_ = node_.host_time();
  });
  node.on<channels::ProcessStatus>(
      [this](const process_status_t& status) { statuses_[status.process] = status; });
}

const group_state_t* GroupClient::state() const {
  return state_ && node_.host_time() - heard_us_ < kSilent_us ? &*state_ : nullptr;
}

const process_state_t* GroupClient::find(const std::string& process) const {
  if (state() == nullptr) return nullptr;
  for (const process_state_t& one : state_->processes) {
    if (one.process == process) return &one;
  }
  return nullptr;
}

const process_status_t* GroupClient::status(const std::string& process) const {
  const auto status = statuses_.find(process);
  if (status == statuses_.end()) return nullptr;
  const process_state_t* one = find(process);
  const bool of_former_run = one != nullptr && !in_session_of(status->second.pid, one->pid);
  return of_former_run ? nullptr : &status->second;
}

bool GroupClient::ready() const { return state() != nullptr && lacking().empty(); }

std::vector<std::string> GroupClient::lacking() const {
  std::vector<std::string> lacking;
  if (state() == nullptr) return {"supervisor: is not heard"};
  for (const process_state_t& process : state_->processes) {
    if (!process.wanted && process.actual != process_state_t::ACTUAL_FAILED) continue;
    const process_status_t* own = status(process.process);
    if (process.actual != process_state_t::ACTUAL_RUNNING) {
      lacking.push_back(process.process + ": " + state_text(process) +
                        (process.reason.empty() ? "" : ": " + process.reason));
    } else if (own == nullptr) {
      lacking.push_back(process.process + ": is not heard");
    } else if (own->health == process_status_t::HEALTH_ILL) {
      lacking.push_back(process.process + ": ill: " + own->reason);
    }
  }
  return lacking;
}

std::map<std::string, std::int32_t> GroupClient::restarts() const {
  std::map<std::string, std::int32_t> restarts;
  if (!state_) return restarts;
  for (const process_state_t& process : state_->processes) {
    restarts[process.process] = process.restarts;
  }
  return restarts;
}

void GroupClient::tell(std::int8_t action, const std::string& process) {
  group_command_t command{};
  command.action = action;
  command.process = process;
  node_.publish<channels::GroupCommand>(std::move(command), node_.data_time());
}

bool GroupClient::wait_until(const std::function<bool()>& so, std::int64_t longest_us) {
  const HostTime deadline_us = node_.host_time() + longest_us;
  while (!so()) {
    if (node_.host_time() >= deadline_us) return false;
    node_.spin_once(kSpin_us);
  }
  return true;
}

}  // namespace cairn::cli
