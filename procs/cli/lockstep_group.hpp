// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "bus/lockstep.hpp"
#include "bus/process.hpp"
#include "procs/cli/run_plan.hpp"

namespace cairn::cli {

/// The processes of a run as nodes of one Lockstep: the same classes, configs and state folders as
/// live, in this process, without sockets, as fast as they go. The same plan gives the same bytes,
/// on any number of threads. What is added first sends first.
class LockstepGroup {
 public:
  /// The plan must outlive this.
  explicit LockstepGroup(const RunPlan& plan) : plan_{plan}, lockstep_{plan.threads} {}

  /// Adds a process as `create(config, node)` makes it; the value is the node it was built on.
  template <class ProcessNode, class Create>
  Result<bus::Node*> add(Create&& create) {
    const auto config = load_config<typename ProcessNode::Config>(
        config_of(plan_, ProcessNode::kName), ProcessNode::kName, bus::kConfigSections);
    if (!config) return tl::make_unexpected(config.error());
    auto state = StateFolder::open(state_of(plan_, ProcessNode::kName));
    if (!state) return tl::make_unexpected(state.error());
    bus::Node& node = lockstep_.add(ProcessNode::kName, std::move(*state));
    auto created = create(*config, node);
    if (!created) return tl::make_unexpected(created.error());
    finish_.push_back([process = std::shared_ptr<ProcessNode>(std::move(*created))] {
      return process->finish();
    });
    return &node;
  }

  template <class ProcessNode>
  Result<bus::Node*> add() {
    return add<ProcessNode>(ProcessNode::create);
  }

  /// A node that is no process: a source, a listener. `bus` as of Lockstep::add.
  bus::Node& add_node(const std::string& name, bus::Bus** bus = nullptr) {
    return lockstep_.add(name, {}, bus);
  }

  /// Host time of all nodes.
  [[nodiscard]] const bus::HostClock& clock() const { return lockstep_.clock(); }

  /// Runs until `source` asks to stop, or `go_on` says no, and ends all processes as a polite
  /// signal ends them live.
  [[nodiscard]] Result<void> run(const bus::Node& source, const std::function<bool()>& go_on);

 private:
  const RunPlan& plan_;
  bus::Lockstep lockstep_;
  std::vector<std::function<Result<void>()>> finish_;  ///< each holds its process
};

}  // namespace cairn::cli
