// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cairn/map_delta_t.hpp>
#include <cairn/map_request_t.hpp>
#include <cstdint>
#include <deque>
#include <set>
#include <span>

#include "bus/node.hpp"
#include "mapping/map_replica.hpp"
#include "mapping/voxel_map.hpp"

namespace cairn {

/// Tells the map's readers what is in it: changes by frames (MAP_DELTA), once a second a digest by
/// which they see what they lack (MAP_DIGEST), and on MAP_REQUEST whole tiles, paced apart from the
/// changes. Readers are told of a copy of the map's classes as of the last batch of changes, so
/// that changes, digests and answers never contradict each other.
class MapPublisher {
 public:
  /// MAP_DELTA comes at least every so many frames (DESIGN rule 4).
  static constexpr int kFramesPerDelta = 4;
  /// Answers take at most a message of 100 kB in this time: 4 MB/s.
  static constexpr std::int64_t kAnswerPeriod_us = 25'000;
  static constexpr std::int64_t kDigestPeriod_us = kMicrosecondsPerSecond;

  /// Goes on with what `map` holds, of which its readers may know some, none, or more. Map and node
  /// must outlive this.
  MapPublisher(const mapping::VoxelMap& map, std::uint64_t map_id, bus::Node& node);

  /// A frame has been dealt with, mapped or not; in these bricks classes changed.
  void frame_done(std::uint64_t map_id, Utime frame, std::span<const mapping::BrickIndex> changed);

 private:
  void begin_batch(std::uint64_t map_id, Utime frame);
  void send_next_change();
  void take_request(const map_request_t& message);
  void make_answer();
  void send_next_answer();
  void digest_is_due();
  void send_digest();

  const mapping::VoxelMap& map_;
  bus::Node& node_;
  mapping::MapReplica told_;
  std::set<mapping::BrickIndex> changed_;
  int frames_since_batch_ = 0;
  std::deque<map_delta_t> changes_;
  std::deque<mapping::TileIndex> asked_;  ///< in the order of asking, each once
  std::deque<map_delta_t> answers_;
  bool digest_due_ = false;
};

}  // namespace cairn
