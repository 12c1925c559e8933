// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cairn/group_command_t.hpp>
#include <cairn/group_state_t.hpp>
#include <cairn/process_status_t.hpp>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "bus/node.hpp"

namespace cairn::cli {

/// A group as one sees it who listens to its bus: what its supervisor and its processes say, and a
/// way to tell it something. It hears what the node hears: the caller spins the node.
class GroupClient {
 public:
  /// The node must outlive this.
  explicit GroupClient(bus::Node& node);
  GroupClient(const GroupClient&) = delete;
  GroupClient& operator=(const GroupClient&) = delete;

  /// The newest word of a supervisor; null where none was heard for 3 s.
  [[nodiscard]] const group_state_t* state() const;

  /// The process in the newest word; null where it is not of this group.
  [[nodiscard]] const process_state_t* find(const std::string& process) const;

  /// The newest word of this run of the process itself; null where there is none.
  [[nodiscard]] const process_status_t* status(const std::string& process) const;

  /// All that should run do, and are well. Otherwise `lacking()` says why not.
  [[nodiscard]] bool ready() const;
  /// "motor: ill: no device /dev/ttyUSB0", of each that should run and is not well.
  [[nodiscard]] std::vector<std::string> lacking() const;

  /// How often each process was started again since the group came up.
  [[nodiscard]] std::map<std::string, std::int32_t> restarts() const;

  /// Sends a GROUP_COMMAND (its ACTION_*); an empty process: the whole group.
  void tell(std::int8_t action, const std::string& process = {});

  /// Spins the node until it is so; false after `longest_us` without.
  bool wait_until(const std::function<bool()>& so, std::int64_t longest_us);

 private:
  bus::Node& node_;
  std::optional<group_state_t> state_;
  HostTime heard_us_ = 0;
  std::map<std::string, process_status_t> statuses_;
};

}  // namespace cairn::cli
