// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/result.hpp"
#include "mapping/byte_stream.hpp"
#include "mapping/voxel_map.hpp"

namespace cairn::mapping {

/// Some or all bricks of a tile as they stand in a file: `places` (index_in_tile) rising, for each
/// 512 bytes of occupied and then 512 of empty evidence.
struct TileContent {
  TileIndex tile;
  std::vector<std::uint16_t> places;
  std::vector<std::uint8_t> planes;
};

/// Appends a tile record: tile x y z (i32), brick count and packed size (u32), checksum of these
/// and of what follows (u64, fnv1a_64), then places (u16) and planes as one zstd frame. `bricks`
/// are of one tile, in the order of index_in_tile. Gives the checksum. The same evidence gives the
/// same bytes.
std::uint64_t put_tile(ByteWriter& out, const VoxelMap& map, std::span<const BrickIndex> bricks);

struct TileRecord {
  TileContent content;
  std::uint64_t checksum = 0;
};

/// Reads one tile record; an error says what is wrong with it. Holds at most a full tile of memory
/// (4.2 MB).
[[nodiscard]] Result<TileRecord> get_tile(ByteReader& in);

/// Replaces the evidence of the bricks in `content`.
void set_tile(const TileContent& content, VoxelMap& map);

}  // namespace cairn::mapping
