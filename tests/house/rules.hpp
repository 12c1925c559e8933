// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "house/source_tree.hpp"

namespace cairn::house {

/// Every procs/*/main.cpp over 40 lines: it does more than wire.
Findings long_mains(const SourceTree& tree);

/// Flags that make a program fail on the next machine: -march=native in any build file.
Findings machine_bound_flags(const SourceTree& tree);

/// Clocks read in lib/ outside lib/bus: time comes with the message.
Findings clock_reads_in_science(const SourceTree& tree);

/// Tests that sleep: slow on a good day and wrong on a bad one.
Findings sleeping_tests(const SourceTree& tree);

/// What was left for later in lib/, procs/ and lcmtypes/, comments included.
Findings left_for_later(const SourceTree& tree);

/// C++ files that do not begin with the licence's short header.
Findings without_licence(const SourceTree& tree);

}  // namespace cairn::house
