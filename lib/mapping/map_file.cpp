// SPDX-License-Identifier: Apache-2.0
#include "mapping/map_file.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "core/atomic_file.hpp"
#include "core/checksum.hpp"
#include "mapping/byte_stream.hpp"
#include "mapping/tile_codec.hpp"

namespace cairn::mapping {
namespace {

constexpr std::array<std::uint8_t, 8> kMagic{'C', 'A', 'I', 'R', 'N', 'M', 'A', 'P'};
constexpr std::uint32_t kVersion = 1;

struct Header {
  double resolution_m = 0;
  MapInfo info;
  std::uint64_t tile_count = 0;
  std::uint64_t brick_count = 0;
};

std::uint64_t mix(std::uint64_t seed, std::uint64_t value) {
  std::array<std::uint8_t, 8> bytes;
  for (std::size_t i = 0; i < 8; ++i) bytes[i] = static_cast<std::uint8_t>(value >> (8 * i));
  return fnv1a_64(bytes, seed);
}

std::uint64_t put_header(ByteWriter& out, const Header& header) {
  out.put_bytes(kMagic);
  out.put(kVersion);
  out.put(header.resolution_m);
  out.put(header.info.map_id);
  out.put(header.info.last_utime);
  out.put(header.tile_count);
  out.put(header.brick_count);
  const std::uint64_t checksum = fnv1a_64(out.from(0));
  out.put(checksum);
  return checksum;
}

Result<std::uint64_t> get_header(ByteReader& in, const MapLimits& limits, Header& header) {
  std::span<const std::uint8_t> magic;
  if (!in.get_bytes(kMagic.size(), magic) ||
      !std::equal(magic.begin(), magic.end(), kMagic.begin())) {
    return fail("is not a cairn map");
  }
  std::uint32_t version = 0;
  if (!in.get(version)) return fail("header is cut short");
  if (version != kVersion) {
    return fail("is a map of version " + std::to_string(version) + ", this program reads version " +
                std::to_string(kVersion));
  }
  if (!in.get(header.resolution_m) || !in.get(header.info.map_id) ||
      !in.get(header.info.last_utime) || !in.get(header.tile_count) ||
      !in.get(header.brick_count)) {
    return fail("header is cut short");
  }
  const std::uint64_t expected = fnv1a_64(in.between(0, in.position()));
  std::uint64_t checksum = 0;
  if (!in.get(checksum)) return fail("header is cut short");
  if (checksum != expected) return fail("header does not match its checksum");
  if (!(header.resolution_m >= 1e-4 && header.resolution_m <= 100)) {
    return fail("resolution of " + std::to_string(header.resolution_m) + " m");
  }
  if (header.brick_count > limits.max_bytes / sizeof(EvidenceBrick) ||
      header.tile_count > header.brick_count) {
    return fail("says it has " + std::to_string(header.brick_count) + " bricks in " +
                std::to_string(header.tile_count) + " tiles, more than the " +
                std::to_string(limits.max_bytes) + " bytes allowed here can hold");
  }
  return checksum;
}

/// Reads all tiles into the map; gives the content id that they and the header make.
Result<std::uint64_t> get_tiles(ByteReader& in, const Header& header, const MapLimits& limits,
                                std::uint64_t header_checksum, VoxelMap& map) {
  std::uint64_t content_id = mix(fnv1a_64({}), header_checksum);
  std::optional<TileIndex> previous;
  for (std::uint64_t i = 0; i < header.tile_count; ++i) {
    const std::string name =
        "tile " + std::to_string(i) + " of " + std::to_string(header.tile_count);
    const auto record = get_tile(in);
    if (!record) return fail(name + " " + record.error().message);
    if (previous && record->content.tile <= *previous) return fail(name + " is out of order");
    previous = record->content.tile;
    content_id = mix(content_id, record->checksum);
    set_tile(record->content, map);
    if (map.bytes() > limits.max_bytes) {
      return fail("holds more than the " + std::to_string(limits.max_bytes) +
                  " bytes allowed here");
    }
  }
  if (map.brick_count() != header.brick_count) {
    return fail("has " + std::to_string(map.brick_count()) + " bricks, its header says " +
                std::to_string(header.brick_count));
  }
  return content_id;
}

Result<LoadedMap> decode(std::span<const std::uint8_t> bytes, const EvidenceConfig& config,
                         const MapLimits& limits) {
  ByteReader in{bytes};
  Header header;
  const auto header_checksum = get_header(in, limits, header);
  if (!header_checksum) return tl::make_unexpected(header_checksum.error());
  LoadedMap loaded{VoxelMap{header.resolution_m, config}, header.info, 0};
  const auto expected = get_tiles(in, header, limits, *header_checksum, loaded.map);
  if (!expected) return tl::make_unexpected(expected.error());
  if (!in.get(loaded.content_id)) return fail("end is cut short");
  if (loaded.content_id != *expected) return fail("does not match its content id");
  if (in.left() != 0) return fail(std::to_string(in.left()) + " bytes too many at the end");
  loaded.map.clear_dirty();
  return loaded;
}

}  // namespace

std::uint64_t make_map_id(std::uint64_t calibration_id, std::uint64_t first_frame_hash) {
  const std::uint64_t id = mix(mix(fnv1a_64({}), calibration_id), first_frame_hash);
  return id != 0 ? id : 1;
}

std::vector<std::uint8_t> encode_map(const VoxelMap& map, const MapInfo& info) {
  ByteWriter out;
  const std::uint64_t header_checksum =
      put_header(out, {map.resolution_m(), info, map.tile_count(), map.brick_count()});
  std::uint64_t content_id = mix(fnv1a_64({}), header_checksum);
  std::vector<BrickIndex> bricks;
  for (const TileIndex tile : map.grid().tiles()) {
    bricks.clear();
    map.grid().for_each_in_tile(
        tile, [&](BrickIndex index, const EvidenceBrick&) { bricks.push_back(index); });
    content_id = mix(content_id, put_tile(out, map, bricks));
  }
  out.put(content_id);
  return out.take();
}

std::uint64_t content_id_of(std::span<const std::uint8_t> encoded) {
  std::uint64_t content_id = 0;
  ByteReader end{encoded.last(std::min(encoded.size(), sizeof(content_id)))};
  return end.get(content_id) ? content_id : 0;
}

Result<LoadedMap> decode_map(std::span<const std::uint8_t> bytes, const std::string& name,
                             const EvidenceConfig& config, const MapLimits& limits) {
  auto loaded = decode(bytes, config, limits);
  if (!loaded) return fail(name + ": " + loaded.error().message);
  return loaded;
}

Result<void> save_map(const std::filesystem::path& path, const VoxelMap& map, const MapInfo& info) {
  return write_file_atomically(path, encode_map(map, info));
}

Result<LoadedMap> load_map(const std::filesystem::path& path, const EvidenceConfig& config,
                           const MapLimits& limits) {
  const auto bytes = read_file(path, limits.max_bytes);
  if (!bytes) return tl::make_unexpected(bytes.error());
  return decode_map(*bytes, path.string(), config, limits);
}

}  // namespace cairn::mapping
