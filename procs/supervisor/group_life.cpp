// SPDX-License-Identifier: Apache-2.0
#include "procs/supervisor/group_life.hpp"

#include <algorithm>

namespace cairn {
namespace {

ProcessLife::Policy policy_of(const GroupProcess& process) {
  ProcessLife::Policy policy;
  policy.restart = process.restart == "always"       ? ProcessLife::Restart::kAlways
                   : process.restart == "on_failure" ? ProcessLife::Restart::kOnFailure
                                                     : ProcessLife::Restart::kNever;
  policy.stop_grace_us = static_cast<std::int64_t>(1e6 * process.stop_grace_s);
  return policy;
}

ProcessLife::Memory first_memory(const GroupProcess& process) {
  ProcessLife::Memory memory;
  memory.wanted = process.at_start;
  if (!memory.wanted) memory.reason = "is not started with the group";
  return memory;
}

}  // namespace

GroupLife::GroupLife(const GroupConfig& group, const GroupMemory& memory) : ending_{memory.ending} {
  for (const GroupProcess& process : group.processes) {
    const auto known = memory.processes.find(process.name);
    const bool is_known = known != memory.processes.end();
    const auto of_life = is_known ? known->second.life : first_memory(process);
    members_.push_back({process, ProcessLife(policy_of(process), of_life), of_life.starts == 0});
  }
}

Result<void> GroupLife::wish(Wish wish, const std::string& process, HostTime now_us) {
  if (ending_) return fail("the group is being ended");
  bool found = false;
  for (Member& member : members_) {
    if (!process.empty() && member.config.name != process) continue;
    found = true;
    member.in_order = !member.life.runs() || wish == Wish::kRestart;
    if (wish == Wish::kStart) member.life.want(now_us);
    if (wish == Wish::kStop) member.life.want_not(now_us);
    if (wish == Wish::kRestart) member.life.restart(now_us);
  }
  if (!found) return fail("the group has no process " + process);
  return {};
}

void GroupLife::end(HostTime now_us) {
  ending_ = true;
  for (Member& member : members_) member.life.want_not(now_us, "ended with the group");
}

bool GroupLife::nothing_runs() const {
  return std::none_of(members_.begin(), members_.end(),
                      [](const Member& member) { return member.life.runs(); });
}

ProcessLife::Action GroupLife::next(std::size_t process, HostTime now_us) {
  Member& member = members_[process];
  const auto action = member.life.next(now_us, !waits_for(member).empty());
  if (action == ProcessLife::Action::kStart) member.in_order = false;
  return action;
}

std::string GroupLife::waits_for(const Member& member) const {
  std::string names;
  if (!member.in_order) return names;
  for (const std::string& name : member.config.after) {
    for (const Member& other : members_) {
      if (other.config.name != name || !other.life.wanted() || other.life.ready()) continue;
      names += (names.empty() ? "" : ", ") + name;
    }
  }
  return names;
}

std::string GroupLife::reason(std::size_t process, HostTime now_us) const {
  const Member& member = members_[process];
  const bool is_to_start =
      member.life.wanted() && !member.life.runs() && !member.life.memory().failed;
  const std::string names = is_to_start ? waits_for(member) : "";
  return names.empty() ? member.life.reason(now_us) : "waits for " + names;
}

}  // namespace cairn
