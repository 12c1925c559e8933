// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "bus/bus.hpp"
#include "core/result.hpp"

namespace cairn::bus {

/// One message of a recording.
struct RecordedMessage {
  std::int64_t recorded_us = 0;  ///< when it was recorded, by the recorder's clock
  RawMessage message;
};

/// Reads LCM's log format (28-byte header: sync word 0xEDA1DA01, event number, timestamp, channel
/// and data lengths; big endian), as lcm-logger writes it. A damaged stretch is skipped to the next
/// event that holds together: every event whose own bytes are whole is read, and the damage is
/// counted.
class RecordingReader {
 public:
  [[nodiscard]] static Result<RecordingReader> open(const std::filesystem::path& path);

  /// The next whole event; nothing at the end.
  [[nodiscard]] std::optional<RecordedMessage> next();

  /// Back to the first event.
  void rewind();

  [[nodiscard]] std::uint64_t size_bytes() const { return size_; }
  [[nodiscard]] std::uint64_t position_bytes() const { return position_; }
  /// Bytes that belong to no whole event, so far.
  [[nodiscard]] std::uint64_t damaged_bytes() const { return damaged_bytes_; }
  /// Stretches of such bytes, so far.
  [[nodiscard]] int damaged_places() const { return damaged_places_; }
  /// "PATH: 2 damaged places, 512 bytes passed over", or empty where the recording is whole.
  [[nodiscard]] std::string damage() const;

 private:
  RecordingReader() = default;
  struct EventHeader {
    std::int64_t recorded_us;
    std::uint64_t channel_size;
    std::uint64_t data_size;
  };
  /// The header at `offset`, if what it says can be true of this file; the sync word is not looked
  /// at.
  [[nodiscard]] std::optional<EventHeader> header_at(std::uint64_t offset) const;
  [[nodiscard]] bool sync_at(std::uint64_t offset) const;
  [[nodiscard]] bool event_may_start_at(std::uint64_t offset) const;
  [[nodiscard]] bool event_starts_within(std::uint64_t begin, std::uint64_t end) const;

  std::string name_;
  std::shared_ptr<const std::uint8_t> bytes_;  ///< the whole file, mapped
  std::uint64_t size_ = 0;
  std::uint64_t position_ = 0;
  std::uint64_t damaged_bytes_ = 0;
  int damaged_places_ = 0;
};

/// Writes the same format; lcm-logplayer plays it.
class RecordingWriter {
 public:
  /// An existing file is refused.
  [[nodiscard]] static Result<RecordingWriter> create(const std::filesystem::path& path);

  /// An error (disk full) leaves all events before it readable.
  [[nodiscard]] Result<void> write(std::int64_t recorded_us, std::string_view channel,
                                   std::span<const std::uint8_t> bytes);
  [[nodiscard]] Result<void> flush();

 private:
  RecordingWriter() = default;
  std::filesystem::path path_;
  std::ofstream file_;
  std::int64_t events_ = 0;
};

}  // namespace cairn::bus
