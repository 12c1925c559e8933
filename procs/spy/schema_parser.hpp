// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "procs/spy/lcm_schema.hpp"

namespace cairn::spy {

/// The types of one file, in its order; whether the types of their fields exist is not looked at,
/// and fingerprints are not computed. An error names the file and the line.
[[nodiscard]] Result<std::vector<MessageType>> parse_file(const SchemaFile& file);

}  // namespace cairn::spy
