// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/result.hpp"

namespace cairn {

/// The restart memory of one process: small checkpoints in the run's state folder, so that a
/// process killed at any moment goes on where it was. With no folder (an empty path) nothing is
/// kept and nothing is found.
///
/// A checkpoint is written in place, alternating between two slots, each with a sequence number and
/// a checksum; it is not synced to disk. A killed process loses nothing; after a power cut the last
/// slot that adds up is used. So it is cheap enough to write once a frame (tens of microseconds)
/// and does not wear out a memory card.
class StateFolder {
 public:
  StateFolder() = default;
  /// Makes the folder if it is missing, and holds it for as long as this or a copy lives: a second
  /// process on the same folder is refused. The lock of a killed process is gone with it.
  [[nodiscard]] static Result<StateFolder> open(const std::filesystem::path& folder);

  [[nodiscard]] bool enabled() const { return !folder_.empty(); }

  /// Where a file of this name would live; empty if there is no folder.
  [[nodiscard]] std::filesystem::path path(const std::string& name) const;

  /// Replaces the checkpoint `name`.
  [[nodiscard]] Result<void> save(const std::string& name,
                                  std::span<const std::uint8_t> bytes) const;

  /// The newest whole checkpoint of this name, or nothing.
  [[nodiscard]] std::optional<std::vector<std::uint8_t>> load(const std::string& name) const;

 private:
  StateFolder(std::filesystem::path folder, std::shared_ptr<const int> lock)
      : folder_{std::move(folder)}, lock_{std::move(lock)} {}

  std::filesystem::path folder_;
  std::shared_ptr<const int> lock_;  ///< a file descriptor, closed with the last copy
};

}  // namespace cairn
