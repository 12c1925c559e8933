// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "core/result.hpp"
#include "core/time.hpp"
#include "mapping/voxel_map.hpp"

namespace cairn::mapping {

/// Which map this is and how far it has come.
struct MapInfo {
  std::uint64_t map_id = 0;
  Utime last_utime = 0;  ///< of the last integrated frame
  friend bool operator==(const MapInfo&, const MapInfo&) = default;
};

/// The id of a map begun with this calibration and this first integrated frame (hashes of their
/// content); never 0.
[[nodiscard]] std::uint64_t make_map_id(std::uint64_t calibration_id,
                                        std::uint64_t first_frame_hash);

/// What may be loaded: a map that would take more memory is refused.
struct MapLimits {
  std::size_t max_bytes = std::size_t{4} << 30;
};

struct LoadedMap {
  VoxelMap map;
  MapInfo info;
  std::uint64_t content_id = 0;  ///< of the file's whole content
};

/// map.cairn, version 1, little endian: magic "CAIRNMAP", version (u32), resolution_m (f64), map id
/// (u64), last utime (i64), tile count (u64), brick count (u64), checksum of all these (u64,
/// fnv1a_64); tile records (tile_codec.hpp) in the order of TileIndex; content id (u64: checksum of
/// the header's and the tiles' checksums). The same map gives the same bytes, however it came
/// about.
[[nodiscard]] std::vector<std::uint8_t> encode_map(const VoxelMap& map, const MapInfo& info);
/// The content id of what encode_map gave.
[[nodiscard]] std::uint64_t content_id_of(std::span<const std::uint8_t> encoded);

/// An error names the file and what is wrong.
[[nodiscard]] Result<LoadedMap> decode_map(std::span<const std::uint8_t> bytes,
                                           const std::string& name, const EvidenceConfig& config,
                                           const MapLimits& limits = {});

[[nodiscard]] Result<void> save_map(const std::filesystem::path& path, const VoxelMap& map,
                                    const MapInfo& info);
[[nodiscard]] Result<LoadedMap> load_map(const std::filesystem::path& path,
                                         const EvidenceConfig& config,
                                         const MapLimits& limits = {});

}  // namespace cairn::mapping
