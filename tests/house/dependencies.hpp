// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>
#include <vector>

#include "house/source_tree.hpp"

namespace cairn::house {

/// Folder to the folders that it includes from, each with one line that does so ("path:line").
using DependencyGraph = std::map<std::string, std::map<std::string, std::string>>;

/// The graph of the folders of lib/ and procs/ ("lib/core", "procs/mapper", ...).
DependencyGraph dependency_graph(const SourceTree& tree);

/// The folders, each after all that it depends on; what is left in a cycle is not in it.
std::vector<std::string> dependency_order(const DependencyGraph& graph);

/// One finding for each step of a cycle, none when there is no cycle.
Findings cycle_in(const DependencyGraph& graph);

/// Includes that point the wrong way: science that knows the bus, messages or LCM; a library that
/// knows a process; LCM's own headers outside lib/bus.
Findings forbidden_includes(const SourceTree& tree);

}  // namespace cairn::house
