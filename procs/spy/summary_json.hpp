// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>

#include "procs/spy/summary.hpp"

namespace cairn::spy {

/// For scripts: the same keys every time, null where something is not known. Sessions are 16 hex
/// digits.
[[nodiscard]] nlohmann::ordered_json to_json(const TrafficSummary& summary);

}  // namespace cairn::spy
