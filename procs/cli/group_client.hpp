// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cairn/group_state_t.hpp>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "bus/node.hpp"
#include "core/result.hpp"

namespace cairn::cli {

/// Whether a group has come up, by its newest GROUP_STATE.
struct Readiness {
  bool ready = false;                ///< all that should run do, and are well
  std::vector<std::string> lacking;  ///< "motor: no device /dev/ttyUSB0", of each that is not
};
[[nodiscard]] Readiness readiness(const group_state_t& state);

/// A group as one sees it who listens to its bus: what its supervisor says, and a way to tell it
/// something. It hears what the node hears: the caller spins the node.
class GroupClient {
 public:
  explicit GroupClient(bus::Node& node);

  /// The newest word of a supervisor; nothing where none was heard for 3 s.
  [[nodiscard]] const group_state_t* state() const;

  /// The process in the newest word; nothing where it is not of this group.
  [[nodiscard]] const process_state_t* find(const std::string& process) const;

  /// Sends a GROUP_COMMAND (its ACTION_*); an empty process: the whole group.
  void tell(std::int8_t action, const std::string& process);

  /// How often each process was started again since the group came up.
  [[nodiscard]] std::map<std::string, std::int32_t> restarts() const;

  /// Spins the node until it is so; false after `longest_us` without.
  bool wait_until(const std::function<bool()>& so, std::int64_t longest_us);

 private:
  bus::Node& node_;
  std::optional<group_state_t> state_;
  HostTime heard_us_ = 0;
};

}  // namespace cairn::cli
