// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "bus/node.hpp"
#include "core/config.hpp"
#include "core/result.hpp"

namespace cairn::bus {

/// The processes of a robot, real or simulated.
inline constexpr std::array<std::string_view, 9> kProcesses{"camera",   "simulator", "stereo",
                                                            "odometry", "localizer", "mapper",
                                                            "planner",  "guard",     "motor"};

/// A config file has one section for each of them and for their supervisor, and `robot` for what
/// they must agree on.
inline constexpr std::array<std::string_view, 11> kConfigSections{
    "robot",  "camera",  "simulator", "stereo", "odometry",  "localizer",
    "mapper", "planner", "guard",     "motor",  "supervisor"};

/// What `run_process` needs to know of a process: its words, its config, and how it is built on a
/// node.
struct ProcessDescription {
  std::string name;
  std::string about;
  VisitConfig visit_config;
  /// What is wrong with the config as a whole, beyond its single keys.
  std::function<Result<void>()> check;
  /// Builds the process on the node; the value's call ends it (saves what it has).
  std::function<Result<std::function<Result<void>()>>(Node&)> start;
};

/// Parses the options that every process has, loads its config strictly, runs it until SIGINT,
/// SIGTERM or its own end. Exit code 0 after a clean end, 2 for bad options or config, 1 for all
/// else.
[[nodiscard]] int run_process(int argc, char** argv, ProcessDescription description);

/// `ProcessNode` has: `kName`, `kAbout`, `Config`, `static Result<std::unique_ptr<ProcessNode>>
/// create(const Config&, Node&)`, `Result<void> finish()`, and, where keys depend on each other,
/// `static Result<void> check(const Config&)`.
template <class ProcessNode>
[[nodiscard]] int run_process(int argc, char** argv) {
  typename ProcessNode::Config config;
  return run_process(
      argc, argv,
      ProcessDescription{ProcessNode::kName, ProcessNode::kAbout,
                         [&](ConfigVisitor& visitor) { config.visit(visitor); },
                         [&]() -> Result<void> {
                           if constexpr (requires { ProcessNode::check(config); }) {
                             return ProcessNode::check(config);
                           }
                           return {};
                         },
                         [&](Node& node) -> Result<std::function<Result<void>()>> {
                           auto created = ProcessNode::create(config, node);
                           if (!created) return tl::make_unexpected(created.error());
                           return [process = std::shared_ptr<ProcessNode>(std::move(*created))] {
                             return process->finish();
                           };
                         }});
}

}  // namespace cairn::bus
