// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "bus/host_clock.hpp"
#include "bus/in_process_bus.hpp"
#include "bus/node.hpp"

namespace cairn::bus {

/// Runs the nodes of a group in one process, without sockets and as fast as they go, on a clock
/// that jumps to the next timer whenever all of them have nothing left to do. In each wave every
/// node that has something to do works off all of it; what they sent is handed out after the wave,
/// in the order in which the nodes were added. So the result depends neither on the machine's speed
/// nor on the number of threads.
class Lockstep {
 public:
  explicit Lockstep(int threads) : threads_{threads} {}

  /// A node to build a process's node class on; lives as long as this.
  /// `bus`, if it is not null, gets the node's own bus, for sources that send bytes as they are.
  [[nodiscard]] Node& add(const std::string& process, StateFolder state, Bus** bus = nullptr);

  /// Host time of all nodes.
  [[nodiscard]] const HostClock& clock() const { return clock_; }

  /// Runs until `source` asks to stop and nothing is left to do, or until `go_on`, which is asked
  /// whenever all is quiet, says no.
  void run(const Node& source, const std::function<bool()>& go_on = {});

 private:
  bool wave();
  void work_off(std::size_t index);

  int threads_;
  ManualClock clock_;
  InProcessHub hub_;
  std::vector<std::unique_ptr<Node>> nodes_;
};

}  // namespace cairn::bus
