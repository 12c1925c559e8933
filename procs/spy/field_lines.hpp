// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "procs/spy/field_tree.hpp"

namespace cairn::spy {

/// What `read_message` gave, for people: one line a field, with units and names of values; safe to
/// show on a terminal.
[[nodiscard]] std::vector<std::string> field_lines(const Schema& schema, const MessageType& type,
                                                   const Json& fields);

}  // namespace cairn::spy
