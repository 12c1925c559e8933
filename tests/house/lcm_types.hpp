// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "house/source_tree.hpp"

namespace cairn::house {

/// What breaks the rules of the message types (lcmtypes/*.lcm): package cairn; one type a file,
/// named like it; a comment on every field's line, with the [unit] where the field is a number;
/// header_t first in every type that is a message (one that is no part of another).
Findings message_type_findings(const SourceTree& tree);

}  // namespace cairn::house
