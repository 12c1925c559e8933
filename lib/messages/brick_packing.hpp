// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/result.hpp"
#include "mapping/map_delta.hpp"
#include "messages/streams.hpp"

namespace cairn::messages {

/// No more bricks than this are packed together.
inline constexpr std::int32_t kMaxBricksPacked = 16384;

/// Packs bricks that are sorted by level, x, y, z, each once: a brick of one class costs some
/// bytes, another its 512 classes, all through zstd.
[[nodiscard]] Bytes pack(std::span<const mapping::BrickClasses> bricks);

/// Refuses bytes that pack cannot have written: order, classes of 3, bricks beyond kBrickLimit,
/// levels over kMaxLevel, another number of bricks than `count`.
[[nodiscard]] Result<std::vector<mapping::BrickClasses>> unpack(
    std::span<const std::uint8_t> packed, std::int32_t count);

/// The order of packing.
[[nodiscard]] bool packs_before(const mapping::BrickClasses& a, const mapping::BrickClasses& b);

/// Nothing if the brick can be sent, else why not.
[[nodiscard]] Result<void> check(const mapping::BrickClasses& brick);

}  // namespace cairn::messages
