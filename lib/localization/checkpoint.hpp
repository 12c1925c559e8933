// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/result.hpp"
#include "localization/localizer.hpp"

namespace cairn::localization {

/// Little end first, with a magic word in front and a checksum behind.
[[nodiscard]] std::vector<std::uint8_t> to_bytes(const LocalizerMemory& memory);

/// An error names what is wrong: size, magic, checksum, a number that is not finite, a rotation
/// that is none, a state that there is not.
[[nodiscard]] Result<LocalizerMemory> memory_from_bytes(std::span<const std::uint8_t> bytes);

}  // namespace cairn::localization
