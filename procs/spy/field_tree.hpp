// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <span>

#include "procs/spy/lcm_schema.hpp"

namespace cairn::spy {

using Json = nlohmann::ordered_json;

/// Whether the bytes are one whole message of this type: its fingerprint, all its fields, nothing
/// left over. The error names the field that does not fit. Takes exactly what the generated
/// decoders take.
[[nodiscard]] Result<void> check_message(const Schema& schema, const MessageType& type,
                                         std::span<const std::uint8_t> bytes);

/// The message's fields, in order, as a JSON object. Arrays of a fixed size are arrays; arrays of a
/// variable size are {"count": N, "first": [...]}, with the first few elements; bytes are
/// {"bytes": N}. Refuses what `check_message` refuses.
[[nodiscard]] Result<Json> read_message(const Schema& schema, const MessageType& type,
                                        std::span<const std::uint8_t> bytes);

}  // namespace cairn::spy
