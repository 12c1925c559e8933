// SPDX-License-Identifier: Apache-2.0
#include "mapping/tile_codec.hpp"

#include <zstd.h>

#include <cstring>
#include <string>

#include "core/checksum.hpp"

namespace cairn::mapping {
namespace {

constexpr int kZstdLevel = 1;
constexpr std::size_t kPlaneBytes = 2 * kBrickVoxels;
constexpr std::size_t kBrickBytes = sizeof(std::uint16_t) + kPlaneBytes;

std::vector<std::uint8_t> raw_bricks(const VoxelMap& map, std::span<const BrickIndex> bricks) {
  ByteWriter raw;
  for (const BrickIndex index : bricks) raw.put(static_cast<std::uint16_t>(index_in_tile(index)));
  for (const BrickIndex index : bricks) {
    const EvidenceBrick* brick = map.grid().find(index);
    raw.put_bytes(brick->occupied_evidence.of);
    raw.put_bytes(brick->empty_evidence().of);
  }
  return raw.take();
}

std::vector<std::uint8_t> compressed(std::span<const std::uint8_t> raw) {
  std::vector<std::uint8_t> packed(ZSTD_compressBound(raw.size()));
  packed.resize(ZSTD_compress(packed.data(), packed.size(), raw.data(), raw.size(), kZstdLevel));
  return packed;
}

std::uint64_t checksum_of(std::span<const std::uint8_t> head,
                          std::span<const std::uint8_t> payload) {
  return fnv1a_64(payload, fnv1a_64(head));
}

Result<TileContent> unpack(TileIndex tile, std::uint32_t brick_count,
                           std::span<const std::uint8_t> payload) {
  std::vector<std::uint8_t> raw(brick_count * kBrickBytes);
  const std::size_t size = ZSTD_decompress(raw.data(), raw.size(), payload.data(), payload.size());
  if (ZSTD_isError(size) != 0)
    return fail(std::string{"cannot unpack: "} + ZSTD_getErrorName(size));
  if (size != raw.size()) return fail("unpacks to the wrong size");
  TileContent content{tile, std::vector<std::uint16_t>(brick_count), {}};
  const std::size_t places_bytes = brick_count * sizeof(std::uint16_t);
  std::memcpy(content.places.data(), raw.data(), places_bytes);
  for (std::size_t i = 0; i < content.places.size(); ++i) {
    if (content.places[i] >= kTileBricks) return fail("a brick lies outside the tile");
    if (i > 0 && content.places[i] <= content.places[i - 1]) return fail("bricks are out of order");
  }
  raw.erase(raw.begin(), raw.begin() + static_cast<std::ptrdiff_t>(places_bytes));
  content.planes = std::move(raw);
  return content;
}

}  // namespace

std::uint64_t put_tile(ByteWriter& out, const VoxelMap& map, std::span<const BrickIndex> bricks) {
  const std::vector<std::uint8_t> payload = compressed(raw_bricks(map, bricks));
  const TileIndex tile = tile_of(bricks.front());
  const std::size_t start = out.size();
  out.put(tile.x);
  out.put(tile.y);
  out.put(tile.z);
  out.put(static_cast<std::uint32_t>(bricks.size()));
  out.put(static_cast<std::uint32_t>(payload.size()));
  const std::uint64_t checksum = checksum_of(out.from(start), payload);
  out.put(checksum);
  out.put_bytes(payload);
  return checksum;
}

Result<TileRecord> get_tile(ByteReader& in) {
  const std::size_t start = in.position();
  TileIndex tile;
  std::uint32_t brick_count = 0;
  std::uint32_t packed_bytes = 0;
  if (!in.get(tile.x) || !in.get(tile.y) || !in.get(tile.z) || !in.get(brick_count) ||
      !in.get(packed_bytes)) {
    return fail("is cut short");
  }
  const auto head = in.between(start, in.position());
  if (!within(tile, kTileLimit)) return fail("lies outside the limits");
  if (brick_count == 0 || brick_count > kTileBricks) {
    return fail("says it has " + std::to_string(brick_count) + " bricks");
  }
  TileRecord record;
  std::span<const std::uint8_t> payload;
  if (!in.get(record.checksum) || !in.get_bytes(packed_bytes, payload)) return fail("is cut short");
  if (record.checksum != checksum_of(head, payload)) return fail("does not match its checksum");
  auto content = unpack(tile, brick_count, payload);
  if (!content) return tl::make_unexpected(content.error());
  record.content = std::move(*content);
  return record;
}

void set_tile(const TileContent& content, VoxelMap& map) {
  const std::span<const std::uint8_t> planes{content.planes};
  for (std::size_t i = 0; i < content.places.size(); ++i) {
    map.set_evidence(brick_in(content.tile, content.places[i]),
                     planes.subspan(i * kPlaneBytes).first<kBrickVoxels>(),
                     planes.subspan(i * kPlaneBytes + kBrickVoxels).first<kBrickVoxels>());
  }
}

}  // namespace cairn::mapping
