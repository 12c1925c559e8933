// SPDX-License-Identifier: Apache-2.0
#include "procs/mapper/map_publisher.hpp"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "messages/map_messages.hpp"

namespace cairn {

namespace channels = bus::channels;

namespace {

/// What goes into one message with room to spare.
constexpr std::size_t kTilesPerAnswer = 2;
/// Data time of what was there before the first frame of this run of the process: older than
/// whatever its readers have of it.
constexpr Utime kBeforeAllFrames = 0;

std::vector<mapping::BrickIndex> bricks_of(const mapping::VoxelMap& map) {
  std::vector<mapping::BrickIndex> bricks;
  map.grid().for_each([&](mapping::BrickIndex brick, const mapping::EvidenceBrick& evidence) {
    if (evidence.known.any()) bricks.push_back(brick);
  });
  return bricks;
}

}  // namespace

MapPublisher::MapPublisher(const mapping::VoxelMap& map, std::uint64_t map_id, bus::Node& node)
    : map_{map}, node_{node} {
  (void)told_.apply(mapping::make_delta(map_, map_id, kBeforeAllFrames, bricks_of(map)));
  node.on<channels::MapRequest>([this](const map_request_t& message) { take_request(message); });
  node.every_host(kAnswerPeriod_us, [this] { send_next_answer(); });
  node.every_host(kDigestPeriod_us, [this] { digest_is_due(); });
}

void MapPublisher::frame_done(std::uint64_t map_id, Utime frame,
                              std::span<const mapping::BrickIndex> changed) {
  changed_.insert(changed.begin(), changed.end());
  if (++frames_since_batch_ >= kFramesPerDelta && changes_.empty()) begin_batch(map_id, frame);
  send_next_change();
}

// The next batch is begun when the one before is out; a message goes out a frame.
void MapPublisher::begin_batch(std::uint64_t map_id, Utime frame) {
  const std::vector<mapping::BrickIndex> bricks(changed_.begin(), changed_.end());
  const mapping::MapDelta delta = mapping::make_delta(map_, map_id, frame, bricks);
  auto messages = messages::to_messages(delta, messages::DeltaKind::kChanges);
  const auto told = told_.apply(delta);
  if (!messages || !told) {
    return node_.refuse(channels::MapDelta::name,
                        messages ? told.error().message : messages.error().message);
  }
  std::move(messages->begin(), messages->end(), std::back_inserter(changes_));
  changed_.clear();
  frames_since_batch_ = 0;
}

void MapPublisher::send_next_change() {
  if (changes_.empty()) return;
  const Utime of_batch = changes_.front().header.utime;
  node_.publish<channels::MapDelta>(std::move(changes_.front()), of_batch);
  changes_.pop_front();
  if (changes_.empty() && digest_due_) send_digest();
}

void MapPublisher::take_request(const map_request_t& message) {
  const auto request = messages::to_request(message);
  if (!request) return node_.refuse(channels::MapRequest::name, request.error().message);
  if (request->map_id != told_.map_id()) {
    ++node_.counter("asked_for_another_map");
    return;
  }
  auto tiles = request->tiles;
  if (tiles.empty()) {
    for (const auto& [tile, state] : told_.tile_states()) tiles.push_back(tile);
  }
  for (const mapping::TileIndex tile : tiles) {
    if (std::find(asked_.begin(), asked_.end(), tile) == asked_.end()) asked_.push_back(tile);
  }
}

// An answer states whole tiles, what is unknown too, so that it also ends what should not be there.
void MapPublisher::make_answer() {
  mapping::MapDelta delta{told_.map_id(), told_.utime(), told_.resolution_m(), {}};
  for (std::size_t i = 0; i < kTilesPerAnswer && !asked_.empty(); ++i) {
    for (int place = 0; place < mapping::kTileBricks; ++place) {
      delta.bricks.push_back(mapping::classes_of(told_, mapping::brick_in(asked_.front(), place)));
    }
    asked_.pop_front();
    ++node_.counter("tiles_answered");
  }
  auto messages = messages::to_messages(delta, messages::DeltaKind::kAnswer);
  if (!messages) return node_.refuse(channels::MapRequest::name, messages.error().message);
  std::move(messages->begin(), messages->end(), std::back_inserter(answers_));
}

void MapPublisher::send_next_answer() {
  if (answers_.empty() && !asked_.empty()) make_answer();
  if (answers_.empty()) return;
  const Utime as_of = answers_.front().header.utime;
  node_.publish<channels::MapDelta>(std::move(answers_.front()), as_of);
  answers_.pop_front();
}

// A digest follows the batch that it speaks of. Where no frames come, nothing is left to wait for.
void MapPublisher::digest_is_due() {
  if (told_.map_id() == 0) return;
  if (digest_due_) send_next_change();
  digest_due_ = true;
  if (changes_.empty()) send_digest();
}

void MapPublisher::send_digest() {
  digest_due_ = false;
  messages::MapDigest digest{told_.map_id(), told_.resolution_m(), told_.utime(), {}};
  for (const auto& [tile, state] : told_.tile_states()) {
    if (state.hash != 0) digest.tiles.push_back({tile, state.hash});
  }
  for (const map_digest_t& page : messages::to_messages(digest, node_.data_time())) {
    node_.publish<channels::MapDigest>(page, node_.data_time());
  }
}

}  // namespace cairn
