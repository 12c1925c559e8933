// SPDX-License-Identifier: Apache-2.0
#include "messages/map_messages.hpp"

#include <algorithm>
#include <cmath>
#include <span>
#include <string>

#include "messages/brick_packing.hpp"

namespace cairn::messages {
namespace {

using mapping::BrickClasses;
using mapping::TileIndex;

constexpr int kTilesPerMessage = 4000;  // 20 bytes each, well under kMaxMapMessage_bytes
constexpr int kMaxPages = 1 << 20;

/// Sorted; of equal bricks the last.
std::vector<BrickClasses> sorted(std::vector<BrickClasses> bricks) {
  std::reverse(bricks.begin(), bricks.end());
  std::stable_sort(bricks.begin(), bricks.end(), packs_before);
  const auto same = [](const BrickClasses& a, const BrickClasses& b) {
    return a.level == b.level && a.brick == b.brick;
  };
  bricks.erase(std::unique(bricks.begin(), bricks.end(), same), bricks.end());
  return bricks;
}

map_delta_t message_of(const mapping::MapDelta& delta, std::span<const BrickClasses> bricks) {
  map_delta_t message{};
  message.header.utime = delta.complete_through;
  message.map_id = static_cast<std::int64_t>(delta.map_id);
  message.resolution_m = delta.resolution_m;
  message.brick_count = static_cast<std::int32_t>(bricks.size());
  message.packed = pack(bricks);
  message.packed_size = static_cast<std::int32_t>(message.packed.size());
  return message;
}

/// Halves until it fits; a single brick always does.
void append_messages(const mapping::MapDelta& delta, std::span<const BrickClasses> bricks,
                     std::vector<map_delta_t>& messages) {
  if (bricks.size() <= kMaxBricksPacked) {
    map_delta_t message = message_of(delta, bricks);
    if (message.getEncodedSize() <= kMaxMapMessage_bytes) {
      messages.push_back(std::move(message));
      return;
    }
  }
  append_messages(delta, bricks.first(bricks.size() / 2), messages);
  append_messages(delta, bricks.subspan(bricks.size() / 2), messages);
}

/// The tiles in pieces of kTilesPerMessage; one empty piece where there are none.
template <class T>
std::vector<std::span<const T>> pieces(const std::vector<T>& tiles) {
  std::vector<std::span<const T>> result;
  std::span<const T> rest(tiles);
  do {
    const std::size_t size = std::min<std::size_t>(rest.size(), kTilesPerMessage);
    result.push_back(rest.first(size));
    rest = rest.subspan(size);
  } while (!rest.empty());
  return result;
}

template <class Message>
void append_tile(Message& message, TileIndex tile) {
  message.tile_x.push_back(tile.x);
  message.tile_y.push_back(tile.y);
  message.tile_z.push_back(tile.z);
  ++message.tile_count;
}

template <class Message>
Result<std::vector<TileIndex>> tiles_of(const Message& message, const std::string& channel) {
  if (!message.counts_agree()) return fail(channel + " tile_count: not that of its lists");
  std::vector<TileIndex> tiles;
  tiles.reserve(message.tile_x.size());
  for (std::size_t i = 0; i < message.tile_x.size(); ++i) {
    tiles.push_back({message.tile_x[i], message.tile_y[i], message.tile_z[i]});
    if (!mapping::within(tiles.back(), mapping::kTileLimit)) {
      return fail(channel + " tile_x, tile_y, tile_z: tile " + std::to_string(i) +
                  " is out of range");
    }
  }
  return tiles;
}

Result<void> check_resolution(double resolution_m, const std::string& channel) {
  if (std::isfinite(resolution_m) && resolution_m > 0) return {};
  return fail(channel + " resolution_m: is not a positive number");
}

}  // namespace

Result<std::vector<map_delta_t>> to_messages(const mapping::MapDelta& delta, DeltaKind kind) {
  if (const auto sound = check_resolution(delta.resolution_m, "MAP_DELTA"); !sound) {
    return fail(sound.error().message);
  }
  for (const BrickClasses& brick : delta.bricks) {
    if (const auto sound = check(brick); !sound) return fail("MAP_DELTA: " + sound.error().message);
  }
  std::vector<map_delta_t> messages;
  append_messages(delta, sorted(delta.bricks), messages);
  if (kind == DeltaKind::kChanges) messages.back().complete_through_utime = delta.complete_through;
  return messages;
}

Result<mapping::MapDelta> to_delta(const map_delta_t& message) {
  if (const auto sound = check_resolution(message.resolution_m, "MAP_DELTA"); !sound) {
    return fail(sound.error().message);
  }
  auto bricks = unpack(message.packed, message.brick_count);
  if (!bricks) return fail("MAP_DELTA packed: " + bricks.error().message);
  return mapping::MapDelta{static_cast<std::uint64_t>(message.map_id), message.header.utime,
                           message.resolution_m, std::move(*bricks)};
}

std::vector<map_digest_t> to_messages(const MapDigest& digest, Utime utime) {
  std::vector<map_digest_t> messages;
  for (const auto piece : pieces(digest.tiles)) {
    map_digest_t message{};
    message.header.utime = utime;
    message.map_id = static_cast<std::int64_t>(digest.map_id);
    message.resolution_m = digest.resolution_m;
    message.complete_through_utime = digest.complete_through;
    message.page = static_cast<std::int32_t>(messages.size());
    for (const TileHash& tile : piece) {
      append_tile(message, tile.tile);
      message.tile_hash.push_back(static_cast<std::int64_t>(tile.hash));
    }
    messages.push_back(std::move(message));
  }
  for (map_digest_t& message : messages) {
    message.page_count = static_cast<std::int32_t>(messages.size());
  }
  return messages;
}

Result<MapDigest> to_digest(const map_digest_t& message) {
  if (const auto sound = check_resolution(message.resolution_m, "MAP_DIGEST"); !sound) {
    return fail(sound.error().message);
  }
  if (message.page < 0 || message.page >= message.page_count || message.page_count > kMaxPages) {
    return fail("MAP_DIGEST page: " + std::to_string(message.page) + " of " +
                std::to_string(message.page_count));
  }
  const auto tiles = tiles_of(message, "MAP_DIGEST");
  if (!tiles) return fail(tiles.error().message);
  MapDigest digest{static_cast<std::uint64_t>(message.map_id),
                   message.resolution_m,
                   message.complete_through_utime,
                   {}};
  digest.tiles.reserve(tiles->size());
  for (std::size_t i = 0; i < tiles->size(); ++i) {
    if (i > 0 && !((*tiles)[i - 1] < (*tiles)[i])) {
      return fail("MAP_DIGEST tile_x, tile_y, tile_z: tile " + std::to_string(i) +
                  " is not in order");
    }
    digest.tiles.push_back({(*tiles)[i], static_cast<std::uint64_t>(message.tile_hash[i])});
  }
  return digest;
}

std::vector<map_request_t> to_messages(const MapRequest& request, Utime utime) {
  std::vector<map_request_t> messages;
  for (const auto piece : pieces(request.tiles)) {
    map_request_t message{};
    message.header.utime = utime;
    message.map_id = static_cast<std::int64_t>(request.map_id);
    for (const TileIndex tile : piece) append_tile(message, tile);
    messages.push_back(std::move(message));
  }
  return messages;
}

Result<MapRequest> to_request(const map_request_t& message) {
  auto tiles = tiles_of(message, "MAP_REQUEST");
  if (!tiles) return fail(tiles.error().message);
  return MapRequest{static_cast<std::uint64_t>(message.map_id), std::move(*tiles)};
}

}  // namespace cairn::messages
