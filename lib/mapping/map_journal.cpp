// SPDX-License-Identifier: Apache-2.0
#include "mapping/map_journal.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <utility>

#include "core/atomic_file.hpp"
#include "core/checksum.hpp"
#include "mapping/byte_stream.hpp"
#include "mapping/tile_codec.hpp"

namespace cairn::mapping {
namespace {

constexpr std::array<std::uint8_t, 8> kMagic{'C', 'A', 'I', 'R', 'N', 'J', 'N', 'L'};
constexpr std::uint32_t kVersion = 1;
constexpr std::size_t kMaxRecordBytes = std::size_t{1} << 30;
constexpr std::int64_t kAppendEvery_us = kMicrosecondsPerSecond;

// A journal is a header: magic, version (u32), content id of the map file it goes on from (u64),
// checksum (u64); and records: body size and checksum (u64 each), body. A body is its number from 0
// (u64), map id (u64), last utime (i64), state size (u64), state, tile count (u64), tile records.

std::vector<std::uint8_t> encode_header(std::uint64_t content_id) {
  ByteWriter out;
  out.put_bytes(kMagic);
  out.put(kVersion);
  out.put(content_id);
  out.put(fnv1a_64(out.from(0)));
  return out.take();
}

/// Calls visit(span of BrickIndex) for each tile's share of bricks that are sorted by tile.
template <class Visit>
void for_each_tile(std::span<const BrickIndex> bricks, Visit&& visit) {
  while (!bricks.empty()) {
    const TileIndex tile = tile_of(bricks.front());
    const auto end = std::find_if(bricks.begin(), bricks.end(),
                                  [tile](BrickIndex brick) { return tile_of(brick) != tile; });
    const auto count = static_cast<std::size_t>(end - bricks.begin());
    visit(bricks.first(count));
    bricks = bricks.subspan(count);
  }
}

std::vector<std::uint8_t> encode_record(std::uint64_t number, const VoxelMap& map,
                                        std::span<const BrickIndex> bricks, const MapInfo& info,
                                        std::span<const std::uint8_t> state) {
  std::uint64_t tile_count = 0;
  for_each_tile(bricks, [&](auto) { ++tile_count; });
  ByteWriter body;
  body.put(number);
  body.put(info.map_id);
  body.put(info.last_utime);
  body.put(static_cast<std::uint64_t>(state.size()));
  body.put_bytes(state);
  body.put(tile_count);
  for_each_tile(bricks, [&](auto of_tile) { put_tile(body, map, of_tile); });
  ByteWriter record;
  record.put(static_cast<std::uint64_t>(body.size()));
  record.put(fnv1a_64(body.from(0)));
  record.put_bytes(body.from(0));
  return record.take();
}

struct JournalRecord {
  MapInfo info;
  std::span<const std::uint8_t> state;
  std::vector<TileContent> tiles;
};

Result<JournalRecord> decode_body(std::span<const std::uint8_t> body, std::uint64_t number,
                                  const MapLimits& limits) {
  ByteReader in{body};
  JournalRecord record;
  std::uint64_t found_number = 0;
  std::uint64_t state_bytes = 0;
  std::uint64_t tile_count = 0;
  if (!in.get(found_number) || !in.get(record.info.map_id) || !in.get(record.info.last_utime) ||
      !in.get(state_bytes) || !in.get_bytes(state_bytes, record.state) || !in.get(tile_count)) {
    return fail("its body is cut short");
  }
  if (found_number != number) return fail("it is numbered " + std::to_string(found_number));
  std::size_t planes_bytes = 0;
  for (std::uint64_t i = 0; i < tile_count; ++i) {
    auto tile = get_tile(in);
    if (!tile) return fail("tile " + std::to_string(i) + " " + tile.error().message);
    planes_bytes += tile->content.planes.size();
    if (planes_bytes > limits.max_bytes) return fail("it holds more than is allowed here");
    record.tiles.push_back(std::move(tile->content));
  }
  if (in.left() != 0) return fail("its body is too long");
  return record;
}

Result<JournalRecord> get_record(ByteReader& in, std::uint64_t number, const MapLimits& limits) {
  std::uint64_t body_bytes = 0;
  std::uint64_t checksum = 0;
  std::span<const std::uint8_t> body;
  if (!in.get(body_bytes) || !in.get(checksum) || body_bytes > kMaxRecordBytes ||
      !in.get_bytes(body_bytes, body)) {
    return fail("it is cut short");
  }
  if (checksum != fnv1a_64(body)) return fail("it does not match its checksum");
  return decode_body(body, number, limits);
}

/// Brings `recovered` up to the last whole record of a journal that goes on from `content_id`;
/// false if it goes on from another file.
bool replay(const std::filesystem::path& path, std::uint64_t content_id, const MapLimits& limits,
            RecoveredMap& recovered) {
  const auto bytes = read_file(path, limits.max_bytes);
  if (!bytes) {
    recovered.note = bytes.error().message;
    return false;
  }
  const std::vector<std::uint8_t> header = encode_header(content_id);
  ByteReader in{*bytes};
  std::span<const std::uint8_t> found;
  if (!in.get_bytes(header.size(), found) ||
      !std::equal(found.begin(), found.end(), header.begin())) {
    recovered.note = path.string() + ": does not belong to the map file, passed over";
    return false;
  }
  recovered.note.clear();
  while (in.left() > 0) {
    const std::size_t start = in.position();
    const auto record = get_record(in, recovered.records, limits);
    if (!record) {
      recovered.note = path.string() + ": record " + std::to_string(recovered.records) +
                       " at byte " + std::to_string(start) + ": " + record.error().message + "; " +
                       std::to_string(bytes->size() - start) + " bytes passed over";
      break;
    }
    for (const TileContent& tile : record->tiles) set_tile(tile, recovered.map);
    if (recovered.map.bytes() > limits.max_bytes) {
      recovered.note = path.string() + ": holds more than the " + std::to_string(limits.max_bytes) +
                       " bytes allowed here; the rest is passed over";
      break;
    }
    recovered.info = record->info;
    recovered.state.assign(record->state.begin(), record->state.end());
    ++recovered.records;
  }
  return true;
}

/// Where the next journal is made before it takes the old one's place.
std::filesystem::path next_path(const std::filesystem::path& map_file) {
  return map_file.string() + ".journal.next";
}

bool write_at(int descriptor, std::size_t offset, std::span<const std::uint8_t> bytes) {
  while (!bytes.empty()) {
    const ssize_t written =
        ::pwrite(descriptor, bytes.data(), bytes.size(), static_cast<off_t>(offset));
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    offset += static_cast<std::size_t>(written);
    bytes = bytes.subspan(static_cast<std::size_t>(written));
  }
  return true;
}

}  // namespace

std::filesystem::path journal_path(const std::filesystem::path& map_file) {
  return map_file.string() + ".journal";
}

Result<MapJournal> MapJournal::start(const std::filesystem::path& map_file, VoxelMap& map,
                                     const MapInfo& info, std::span<const std::uint8_t> state) {
  const std::vector<std::uint8_t> encoded = encode_map(map, info);
  std::vector<std::uint8_t> journal = encode_header(content_id_of(encoded));
  const std::vector<std::uint8_t> first = encode_record(0, map, {}, info, state);
  journal.insert(journal.end(), first.begin(), first.end());

  // Between any two of these steps one of the two journals belongs to the map file that is there.
  const std::filesystem::path next = next_path(map_file);
  auto written = write_file_atomically(next, journal);
  if (!written) return tl::make_unexpected(written.error());
  MapJournal started{journal_path(map_file), ::open(next.c_str(), O_WRONLY | O_CLOEXEC),
                     journal.size()};
  if (started.descriptor_ < 0)
    return fail(next.string() + ": cannot open: " + std::strerror(errno));
  written = write_file_atomically(map_file, encoded);
  if (!written) return tl::make_unexpected(written.error());
  if (::rename(next.c_str(), started.path_.c_str()) != 0) {
    return fail(started.path_.string() + ": cannot write: " + std::strerror(errno));
  }
  map.clear_dirty();
  return started;
}

MapJournal::MapJournal(std::filesystem::path path, int descriptor, std::size_t length)
    : path_{std::move(path)}, descriptor_{descriptor}, length_{length} {}

MapJournal::MapJournal(MapJournal&& other) noexcept
    : path_{std::move(other.path_)},
      descriptor_{std::exchange(other.descriptor_, -1)},
      length_{other.length_},
      records_{other.records_},
      last_append_{other.last_append_} {}

MapJournal& MapJournal::operator=(MapJournal&& other) noexcept {
  std::swap(path_, other.path_);
  std::swap(descriptor_, other.descriptor_);
  std::swap(length_, other.length_);
  std::swap(records_, other.records_);
  std::swap(last_append_, other.last_append_);
  return *this;
}

MapJournal::~MapJournal() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

Result<bool> MapJournal::append(VoxelMap& map, const MapInfo& info,
                                std::span<const std::uint8_t> state, HostTime now) {
  if (last_append_ && now - *last_append_ < kAppendEvery_us) return false;
  last_append_ = now;
  const std::vector<BrickIndex> dirty = map.dirty_bricks();
  const std::vector<std::uint8_t> record = encode_record(records_, map, dirty, info, state);
  if (record.size() > kMaxRecordBytes) {
    return fail(path_.string() + ": " + std::to_string(record.size()) +
                " bytes changed, too much for one record; start a new journal");
  }
  if (!write_at(descriptor_, length_, record)) {
    const std::string reason = std::strerror(errno);
    // Only frees space: the next append overwrites a torn record, and recover_map passes over it.
    [[maybe_unused]] const int cut = ::ftruncate(descriptor_, static_cast<off_t>(length_));
    return fail(path_.string() + ": cannot append: " + reason);
  }
  length_ += record.size();
  ++records_;
  map.clear_dirty();
  return true;
}

Result<std::optional<RecoveredMap>> recover_map(const std::filesystem::path& map_file,
                                                const EvidenceConfig& config,
                                                const MapLimits& limits) {
  std::error_code ignored;
  if (!std::filesystem::exists(map_file, ignored)) return std::optional<RecoveredMap>{};
  auto loaded = load_map(map_file, config, limits);
  if (!loaded) return tl::make_unexpected(loaded.error());
  RecoveredMap recovered{std::move(loaded->map), loaded->info, {}, 0, {}};
  if (!replay(journal_path(map_file), loaded->content_id, limits, recovered)) {
    const std::string note = recovered.note;
    if (!replay(next_path(map_file), loaded->content_id, limits, recovered)) recovered.note = note;
  }
  recovered.map.clear_dirty();
  return std::optional<RecoveredMap>{std::move(recovered)};
}

}  // namespace cairn::mapping
