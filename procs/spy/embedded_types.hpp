// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "procs/spy/lcm_schema.hpp"

namespace cairn::spy {

/// The project's lcmtypes/*.lcm as they were when this program was built.
[[nodiscard]] std::vector<SchemaFile> embedded_files();

}  // namespace cairn::spy
