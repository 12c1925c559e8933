// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/result.hpp"
#include "core/time.hpp"
#include "mapping/map_file.hpp"
#include "mapping/voxel_map.hpp"

namespace cairn::mapping {

/// A map file and, beside it as FILE.journal, what changed since. A process killed at any moment
/// loses at most what came after the last append; a power cut may cost what the system had not yet
/// written.
class MapJournal {
 public:
  /// Saves the map to `map_file` and begins an empty journal that holds only `state` (the owner's
  /// own, opaque). This is also how a journal that has grown large is folded into the file: assign
  /// the result over the old one. On error what was there before is still whole and the old journal
  /// may be used on.
  [[nodiscard]] static Result<MapJournal> start(const std::filesystem::path& map_file,
                                                VoxelMap& map, const MapInfo& info,
                                                std::span<const std::uint8_t> state);

  MapJournal(MapJournal&& other) noexcept;
  MapJournal& operator=(MapJournal&& other) noexcept;
  MapJournal(const MapJournal&) = delete;
  MapJournal& operator=(const MapJournal&) = delete;
  ~MapJournal();

  /// Appends the dirty bricks and `state`, and makes the map clean. False, and nothing done, less
  /// than a second after the last append. On error (a full disk) the map stays dirty, all earlier
  /// appends stay whole, and the call a second later tries again.
  [[nodiscard]] Result<bool> append(VoxelMap& map, const MapInfo& info,
                                    std::span<const std::uint8_t> state, HostTime now);

  /// Of the journal alone.
  [[nodiscard]] std::size_t bytes() const { return length_; }

 private:
  MapJournal(std::filesystem::path path, int descriptor, std::size_t length);

  std::filesystem::path path_;
  int descriptor_ = -1;
  std::size_t length_ = 0;
  std::uint64_t records_ = 1;
  std::optional<HostTime> last_append_;
};

[[nodiscard]] std::filesystem::path journal_path(const std::filesystem::path& map_file);

struct RecoveredMap {
  VoxelMap map;
  MapInfo info;
  std::vector<std::uint8_t> state;  ///< as last appended; empty if the journal was of no use
  std::size_t records = 0;          ///< of the journal, that were used
  std::string note;                 ///< what of the journal was passed over and why; empty: nothing
};

/// The map as last appended. A torn or damaged end of the journal is passed over, as is a journal
/// that belongs to another file. Nothing if there is no map file. A damaged map file is an error.
/// Changes nothing on disk; to go on from here, MapJournal::start.
[[nodiscard]] Result<std::optional<RecoveredMap>> recover_map(const std::filesystem::path& map_file,
                                                              const EvidenceConfig& config,
                                                              const MapLimits& limits = {});

}  // namespace cairn::mapping
