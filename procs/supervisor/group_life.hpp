// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/result.hpp"
#include "procs/supervisor/group_config.hpp"
#include "procs/supervisor/group_memory.hpp"
#include "procs/supervisor/process_life.hpp"

namespace cairn {

/// The lives of a group's processes together: who is started when, and what people tell it. Like
/// ProcessLife it knows no process and reads no clock.
class GroupLife {
 public:
  /// Goes on with what is remembered of processes that the group has.
  GroupLife(const GroupConfig& group, const GroupMemory& memory);

  enum class Wish { kStart, kStop, kRestart };
  /// An empty name: all of them. An error: there is no such process.
  [[nodiscard]] Result<void> wish(Wish wish, const std::string& process, HostTime now_us);

  /// From now on all are to end, whatever else is wished.
  void end(HostTime now_us);
  [[nodiscard]] bool ending() const { return ending_; }
  [[nodiscard]] bool nothing_runs() const;

  /// What is to be done now. One that stands after others is not started before they are ready,
  /// unless it has died: then it is as free as any.
  [[nodiscard]] ProcessLife::Action next(std::size_t process, HostTime now_us);

  [[nodiscard]] std::size_t size() const { return members_.size(); }
  [[nodiscard]] const std::string& name(std::size_t process) const {
    return members_[process].config.name;
  }
  [[nodiscard]] const GroupProcess& config(std::size_t process) const {
    return members_[process].config;
  }
  [[nodiscard]] ProcessLife& life(std::size_t process) { return members_[process].life; }
  [[nodiscard]] const ProcessLife& life(std::size_t process) const {
    return members_[process].life;
  }
  [[nodiscard]] std::string reason(std::size_t process, HostTime now_us) const;

 private:
  struct Member {
    GroupProcess config;
    ProcessLife life;
    bool in_order;  ///< its next start waits for those that it stands after
  };
  [[nodiscard]] std::string waits_for(const Member& member) const;

  std::vector<Member> members_;
  bool ending_;
};

}  // namespace cairn
