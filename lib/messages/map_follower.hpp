// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cairn/map_delta_t.hpp>
#include <cairn/map_digest_t.hpp>
#include <cairn/map_request_t.hpp>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <vector>

#include "core/result.hpp"
#include "core/time.hpp"
#include "mapping/map_replica.hpp"
#include "messages/map_messages.hpp"

namespace cairn::messages {

/// How every process reads the map: takes MAP_DELTA and MAP_DIGEST, keeps a copy of the map, and
/// says what to ask mapper for. Loss, repetition, disorder and restarts delay the copy and never
/// spoil it.
///
/// What mapper learned at frame k takes effect at frame k + 8 (DESIGN rule 4), however early it
/// came: call note_frame for each frame as it arrives (ODOMETRY, in order), and apply_for_frame
/// with the frame that is about to be worked on. Readers that feed nothing back (pages, recorders)
/// call apply_through with the largest Utime instead.
class MapFollower {
 public:
  static constexpr std::size_t kEffectFrames = 8;
  /// Requests come at most this often, for at most so many tiles, and again only after a while.
  static constexpr std::int64_t kRequestPeriod_us = 100'000;
  static constexpr std::size_t kTilesPerRequest = 8;
  static constexpr std::int64_t kPatience_us = 2'000'000;

  /// Refuses what to_delta refuses, levels over 0, and a delta when too many wait to take effect.
  [[nodiscard]] Result<void> put(const map_delta_t& message);
  /// Refuses what to_digest refuses.
  [[nodiscard]] Result<void> put(const map_digest_t& message);

  /// The frames of the run, rising. Set back by more than a second, the copy begins anew.
  void note_frame(Utime frame);
  /// Lets take effect what takes effect at `frame` or before.
  void apply_for_frame(Utime frame);
  /// Lets take effect all that is of frames up to `through`.
  void apply_through(Utime through);

  [[nodiscard]] const mapping::MapReplica& map() const { return replica_; }
  /// What became different since it was last asked; for views that are derived from the map.
  [[nodiscard]] mapping::MapReplica::Changes take_changes();

  /// What to send to mapper now: tiles that the last digest showed to be missing or out of date,
  /// nearest to `near_m` (in the map) first. Mostly nothing.
  [[nodiscard]] std::optional<map_request_t> next_request(HostTime now, Utime data_time,
                                                          const Eigen::Vector3d& near_m);

  /// Tiles that are known to be missing or out of date.
  [[nodiscard]] std::size_t tiles_lacking() const { return lacking_.size(); }
  /// Whether a digest was compared with the copy since it began, and nothing is known to be
  /// lacking.
  [[nodiscard]] bool whole() const { return compared_ && lacking_.empty(); }
  /// Batches of changes that came after the frame at which they should have taken effect. They, and
  /// answers to requests, are what can make a live run differ from lockstep.
  [[nodiscard]] std::int64_t late() const { return late_; }

 private:
  struct Digest {
    MapDigest content;
    std::int64_t session = 0;
    Utime sent = 0;
    std::int32_t page_count = 0;
    std::int32_t next_page = 0;
  };

  void start_over();
  void compare_before(Utime next);
  void compare(const Digest& digest);

  mapping::MapReplica replica_;
  bool started_over_ = false;
  bool compared_ = false;
  std::multimap<Utime, mapping::MapDelta> waiting_;
  std::deque<Utime> frames_;
  std::optional<Utime> applied_through_;
  std::optional<Digest> coming_;  ///< some of its pages
  std::optional<Digest> digest_;  ///< whole, not compared yet
  std::uint64_t lacking_map_id_ = 0;
  double lacking_resolution_m_ = 0;
  std::map<mapping::TileIndex, std::optional<HostTime>> lacking_;  ///< when asked for
  std::optional<HostTime> last_request_;
  std::int64_t late_ = 0;
};

}  // namespace cairn::messages
