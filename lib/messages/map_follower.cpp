// SPDX-License-Identifier: Apache-2.0
#include "messages/map_follower.hpp"

#include <algorithm>
#include <limits>
#include <string>
#include <utility>

namespace cairn::messages {
namespace {

using mapping::TileIndex;

constexpr std::size_t kMaxWaiting = 1024;
constexpr std::size_t kFramesKept = 64;

double distance_m(TileIndex tile, double tile_m, const Eigen::Vector3d& from_m) {
  const Eigen::Vector3d centre_m = (Eigen::Vector3d(tile.x, tile.y, tile.z).array() + 0.5) * tile_m;
  return (centre_m - from_m).norm();
}

}  // namespace

Result<void> MapFollower::put(const map_delta_t& message) {
  auto delta = to_delta(message);
  if (!delta) return tl::make_unexpected(delta.error());
  for (const mapping::BrickClasses& brick : delta->bricks) {
    if (brick.level != 0) return fail("MAP_DELTA: a brick of level " + std::to_string(brick.level));
  }
  if (waiting_.size() >= kMaxWaiting) {
    return fail("MAP_DELTA: " + std::to_string(kMaxWaiting) + " wait already");
  }
  const Utime utime = delta->complete_through;
  const bool ends_batch = message.complete_through_utime != 0;
  if (ends_batch && applied_through_ && utime <= *applied_through_) ++late_;
  waiting_.emplace(utime, std::move(*delta));
  return {};
}

Result<void> MapFollower::put(const map_digest_t& message) {
  auto page = to_digest(message);
  if (!page) return tl::make_unexpected(page.error());
  if (message.page == 0) {
    coming_ = Digest{{page->map_id, page->resolution_m, page->complete_through, {}},
                     message.header.session,
                     message.header.utime,
                     message.page_count,
                     0};
  }
  if (!coming_ || coming_->next_page != message.page ||
      coming_->session != message.header.session || coming_->content.map_id != page->map_id ||
      coming_->content.complete_through != page->complete_through ||
      coming_->page_count != message.page_count) {
    coming_.reset();  // a page is missing: the next digest is not far
    return {};
  }
  std::vector<TileHash>& tiles = coming_->content.tiles;
  if (!tiles.empty() && !page->tiles.empty() && !(tiles.back().tile < page->tiles.front().tile)) {
    coming_.reset();
    return fail("MAP_DIGEST tile_x, tile_y, tile_z: pages are not in order");
  }
  tiles.insert(tiles.end(), page->tiles.begin(), page->tiles.end());
  if (++coming_->next_page == coming_->page_count) {
    digest_ = std::move(coming_);
    coming_.reset();
  }
  return {};
}

void MapFollower::note_frame(Utime frame) {
  if (!frames_.empty() && frame <= frames_.back()) {
    if (frame >= frames_.back() - kMicrosecondsPerSecond) return;
    start_over();
    frames_.clear();
    applied_through_.reset();
  }
  frames_.push_back(frame);
  if (frames_.size() > kFramesKept) frames_.pop_front();
}

void MapFollower::apply_for_frame(Utime frame) {
  const auto after = std::upper_bound(frames_.begin(), frames_.end(), frame);
  const auto known = static_cast<std::size_t>(after - frames_.begin());
  // Of the frames, the last is `frame` itself.
  apply_through(known > kEffectFrames ? frames_[known - 1 - kEffectFrames] : 0);
}

void MapFollower::apply_through(Utime through) {
  while (!waiting_.empty() && waiting_.begin()->first <= through) {
    const auto first = waiting_.begin();
    compare_before(first->first);
    (void)replica_.apply(first->second);  // put has checked it
    waiting_.erase(first);
  }
  if (!applied_through_ || through > *applied_through_) applied_through_ = through;
  compare_before(through == std::numeric_limits<Utime>::max() ? through : through + 1);
}

mapping::MapReplica::Changes MapFollower::take_changes() {
  auto changes = replica_.take_changes();
  changes.started_over |= std::exchange(started_over_, false);
  return changes;
}

void MapFollower::start_over() {
  replica_ = {};
  started_over_ = true;
  compared_ = false;
  waiting_.clear();
  coming_.reset();
  digest_.reset();
  lacking_.clear();
}

// A digest is compared when all that it speaks of is in, and nothing later.
void MapFollower::compare_before(Utime next) {
  if (!digest_ || digest_->content.complete_through >= next) return;
  const Digest digest = std::move(*digest_);
  digest_.reset();
  compare(digest);
}

void MapFollower::compare(const Digest& digest) {
  const MapDigest& theirs = digest.content;
  const bool other_map =
      theirs.map_id != replica_.map_id() || theirs.resolution_m != replica_.resolution_m();
  if (other_map && replica_.map_id() != 0) {
    if (digest.sent < replica_.utime()) return;
    replica_ = {};
    started_over_ = true;
  }
  compared_ = true;
  const auto asked = std::exchange(lacking_, {});
  const auto lacks = [&](TileIndex tile, std::uint64_t hash) {
    const auto ours = replica_.tile_state(tile);
    if (ours.hash == hash || ours.utime > theirs.complete_through) return;
    const auto before = asked.find(tile);
    const bool same = before != asked.end() && lacking_map_id_ == theirs.map_id;
    lacking_[tile] = same ? before->second : std::nullopt;
  };
  for (const TileHash& tile : theirs.tiles) lacks(tile.tile, tile.hash);
  for (const auto& [tile, state] : replica_.tile_states()) {
    const auto at =
        std::lower_bound(theirs.tiles.begin(), theirs.tiles.end(), tile,
                         [](const TileHash& have, TileIndex wanted) { return have.tile < wanted; });
    if (at == theirs.tiles.end() || at->tile != tile) lacks(tile, 0);
  }
  lacking_map_id_ = theirs.map_id;
  lacking_resolution_m_ = theirs.resolution_m;
}

std::optional<map_request_t> MapFollower::next_request(HostTime now, Utime data_time,
                                                       const Eigen::Vector3d& near_m) {
  if (last_request_ && now < *last_request_ + kRequestPeriod_us) return std::nullopt;
  std::vector<std::pair<double, TileIndex>> wanted;
  const double tile_m = lacking_resolution_m_ * mapping::kTileSide * mapping::kBrickSide;
  for (const auto& [tile, asked] : lacking_) {
    if (!asked || now >= *asked + kPatience_us) {
      wanted.emplace_back(distance_m(tile, tile_m, near_m), tile);
    }
  }
  if (wanted.empty()) return std::nullopt;
  std::sort(wanted.begin(), wanted.end());
  if (wanted.size() > kTilesPerRequest) wanted.resize(kTilesPerRequest);
  MapRequest request{lacking_map_id_, {}};
  for (const auto& [distance, tile] : wanted) {
    request.tiles.push_back(tile);
    lacking_[tile] = now;
  }
  last_request_ = now;
  return to_messages(request, data_time).front();
}

}  // namespace cairn::messages
