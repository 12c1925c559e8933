// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "procs/spy/lcm_schema.hpp"

namespace cairn::spy {

/// The number that LCM writes before every message of this type: of its fields' names, primitive
/// types and dimensions, and of the types within it. The types' and packages' own names and
/// constants are not in it. Method: LCM 1.3.1, lcmgen/lcmgen.c (lcm_struct_hash) and emit_cpp.c
/// (_computeHash). All types that it uses must be in `types`.
[[nodiscard]] std::uint64_t fingerprint(
    const std::map<std::string, MessageType, std::less<>>& types, const MessageType& type);

}  // namespace cairn::spy
