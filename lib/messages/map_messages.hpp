// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cairn/map_delta_t.hpp>
#include <cairn/map_digest_t.hpp>
#include <cairn/map_request_t.hpp>
#include <cstdint>
#include <vector>

#include "core/result.hpp"
#include "core/time.hpp"
#include "mapping/map_delta.hpp"

namespace cairn::messages {

/// No MAP_DELTA, MAP_DIGEST or MAP_REQUEST message is larger [bytes].
inline constexpr int kMaxMapMessage_bytes = 100'000;

/// Why bricks are sent.
enum class DeltaKind {
  kChanges,  ///< they changed
  kAnswer,   ///< somebody asked for them
};

/// One message or more, each at most kMaxMapMessage_bytes, bricks sorted by level, x, y, z; of
/// equal bricks the last counts. `header.utime` of all is delta.complete_through;
/// `complete_through_utime` is set in the last message of kChanges alone, so that it holds for
/// whoever got them all, and is 0 in the others. No bricks: one message still. Refuses what no
/// receiver would take: a class of 3, a brick beyond kBrickLimit, a level over kMaxLevel.
[[nodiscard]] Result<std::vector<map_delta_t>> to_messages(const mapping::MapDelta& delta,
                                                           DeltaKind kind);

/// The bricks of one message; complete_through is the message's header.utime, the data time that
/// the bricks are of. Whether everything up to a frame is in, `message.complete_through_utime`
/// says. Refuses what to_messages cannot have written.
[[nodiscard]] Result<mapping::MapDelta> to_delta(const map_delta_t& message);

/// Bricks of levels 0 to this one: voxels of 1, 2, 4, 8 times the map's resolution.
inline constexpr std::uint8_t kMaxLevel = 3;

/// What tells whether a tile is up to date.
struct TileHash {
  mapping::TileIndex tile;
  std::uint64_t hash = 0;  ///< of the tile's voxel classes
  friend bool operator==(const TileHash&, const TileHash&) = default;
};

/// What mapper has, or one page of it.
struct MapDigest {
  std::uint64_t map_id = 0;
  double resolution_m = 0;
  Utime complete_through = 0;
  std::vector<TileHash> tiles;  ///< sorted, each once
};

/// In pages of at most kMaxMapMessage_bytes; one page where there are no tiles.
[[nodiscard]] std::vector<map_digest_t> to_messages(const MapDigest& digest, Utime utime);

/// One page. Refuses tiles out of range or out of order, a resolution that is not positive, and a
/// page beyond page_count.
[[nodiscard]] Result<MapDigest> to_digest(const map_digest_t& message);

/// Tiles that somebody lacks.
struct MapRequest {
  std::uint64_t map_id = 0;
  std::vector<mapping::TileIndex> tiles;  ///< none = all of them
};

[[nodiscard]] std::vector<map_request_t> to_messages(const MapRequest& request, Utime utime);

/// Refuses tiles out of range.
[[nodiscard]] Result<MapRequest> to_request(const map_request_t& message);

}  // namespace cairn::messages
