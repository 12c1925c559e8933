// SPDX-License-Identifier: Apache-2.0
#include "bus/recording.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

namespace cairn::bus {
namespace {

constexpr std::uint32_t kSync = 0xEDA1DA01;
constexpr std::uint64_t kHeaderSize = 28;
constexpr std::uint64_t kMaxChannelSize = 63;       // LCM's own limit
constexpr std::uint64_t kMaxDataSize = 1ULL << 28;  // LCM's own limit

std::uint64_t big_endian(const std::uint8_t* bytes, int count) {
  std::uint64_t value = 0;
  for (int i = 0; i < count; ++i) value = value << 8 | bytes[i];
  return value;
}

void append_big_endian(std::vector<std::uint8_t>& bytes, std::uint64_t value, int count) {
  for (int i = count - 1; i >= 0; --i) bytes.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
}

}  // namespace

Result<RecordingReader> RecordingReader::open(const std::filesystem::path& path) {
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0) return fail(path.string() + ": cannot open: " + std::strerror(errno));
  struct stat info {};
  if (::fstat(fd, &info) != 0 || !S_ISREG(info.st_mode)) {
    ::close(fd);
    return fail(path.string() + ": is not a file");
  }
  RecordingReader reader;
  reader.name_ = path.string();
  reader.size_ = static_cast<std::uint64_t>(info.st_size);
  if (reader.size_ > 0) {
    void* mapped = ::mmap(nullptr, reader.size_, PROT_READ, MAP_PRIVATE, fd, 0);
    const int problem = errno;
    ::close(fd);
    if (mapped == MAP_FAILED)
      return fail(path.string() + ": cannot map: " + std::strerror(problem));
    const std::uint64_t size = reader.size_;
    reader.bytes_ = {static_cast<const std::uint8_t*>(mapped), [size](const std::uint8_t* bytes) {
                       ::munmap(const_cast<std::uint8_t*>(bytes), size);
                     }};
  } else {
    ::close(fd);
    return fail(path.string() + ": is empty");
  }
  const auto first = reader.next();
  if (!first) return fail(path.string() + ": holds no LCM event; is it a recording?");
  reader.rewind();
  return reader;
}

void RecordingReader::rewind() {
  position_ = 0;
  damaged_bytes_ = 0;
  damaged_places_ = 0;
}

std::string RecordingReader::damage() const {
  if (damaged_places_ == 0) return "";
  return name_ + ": " + std::to_string(damaged_places_) +
         (damaged_places_ == 1 ? " damaged place, " : " damaged places, ") +
         std::to_string(damaged_bytes_) + " bytes passed over";
}

std::optional<RecordingReader::EventHeader> RecordingReader::header_at(std::uint64_t offset) const {
  if (offset + kHeaderSize > size_) return std::nullopt;
  const std::uint8_t* bytes = bytes_.get() + offset;
  const EventHeader header{static_cast<std::int64_t>(big_endian(bytes + 12, 8)),
                           big_endian(bytes + 20, 4), big_endian(bytes + 24, 4)};
  if (header.channel_size < 1 || header.channel_size > kMaxChannelSize ||
      header.data_size > kMaxDataSize ||
      offset + kHeaderSize + header.channel_size + header.data_size > size_) {
    return std::nullopt;
  }
  const auto printable = [](std::uint8_t c) { return c > ' ' && c < 127; };
  const std::uint8_t* channel = bytes + kHeaderSize;
  if (!std::all_of(channel, channel + header.channel_size, printable)) return std::nullopt;
  return header;
}

bool RecordingReader::sync_at(std::uint64_t offset) const {
  return offset + 4 <= size_ && big_endian(bytes_.get() + offset, 4) == kSync;
}

// An event is over where the next begins: at the end of the file, at a sync word, at a header whose
// sync word alone is damaged, or in a tail too short to be told.
bool RecordingReader::event_may_start_at(std::uint64_t offset) const {
  return size_ - offset < kHeaderSize || sync_at(offset) || header_at(offset).has_value();
}

bool RecordingReader::event_starts_within(std::uint64_t begin, std::uint64_t end) const {
  for (std::uint64_t offset = begin; offset < end; ++offset) {
    if (sync_at(offset) && header_at(offset)) return true;
  }
  return false;
}

std::optional<RecordedMessage> RecordingReader::next() {
  const std::uint64_t start = position_;
  for (std::uint64_t offset = start; offset + kHeaderSize <= size_; ++offset) {
    // Right after a whole event a header counts without its sync word; anywhere else the word must
    // be there.
    if (!sync_at(offset) && (offset != start || start == 0)) continue;
    const auto header = header_at(offset);
    if (!header) continue;
    const std::uint64_t data = offset + kHeaderSize + header->channel_size;
    const std::uint64_t end = data + header->data_size;
    // What follows may be junk; but a length that reaches into another event is a damaged one.
    if (!event_may_start_at(end) && event_starts_within(offset + kHeaderSize, end)) continue;
    if (offset > start) {
      damaged_bytes_ += offset - start;
      ++damaged_places_;
    }
    position_ = end;
    const std::uint8_t* bytes = bytes_.get();
    return RecordedMessage{
        header->recorded_us,
        {{reinterpret_cast<const char*>(bytes + offset + kHeaderSize), header->channel_size},
         {bytes + data, bytes + end}}};
  }
  if (position_ < size_) {
    damaged_bytes_ += size_ - position_;
    ++damaged_places_;
    position_ = size_;
  }
  return std::nullopt;
}

Result<RecordingWriter> RecordingWriter::create(const std::filesystem::path& path) {
  std::error_code error;
  if (std::filesystem::exists(path, error)) {
    return fail(path.string() + ": exists already; a recording is not written over");
  }
  RecordingWriter writer;
  writer.path_ = path;
  writer.file_.open(path, std::ios::binary);
  if (!writer.file_) return fail(path.string() + ": cannot write: " + std::strerror(errno));
  return writer;
}

Result<void> RecordingWriter::write(std::int64_t recorded_us, std::string_view channel,
                                    std::span<const std::uint8_t> bytes) {
  std::vector<std::uint8_t> event;
  event.reserve(kHeaderSize + channel.size() + bytes.size());
  append_big_endian(event, kSync, 4);
  append_big_endian(event, static_cast<std::uint64_t>(events_++), 8);
  append_big_endian(event, static_cast<std::uint64_t>(recorded_us), 8);
  append_big_endian(event, channel.size(), 4);
  append_big_endian(event, bytes.size(), 4);
  event.insert(event.end(), channel.begin(), channel.end());
  event.insert(event.end(), bytes.begin(), bytes.end());
  file_.write(reinterpret_cast<const char*>(event.data()),
              static_cast<std::streamsize>(event.size()));
  if (!file_) return fail(path_.string() + ": cannot write: " + std::strerror(errno));
  return {};
}

Result<void> RecordingWriter::flush() {
  file_.flush();
  if (!file_) return fail(path_.string() + ": cannot write: " + std::strerror(errno));
  return {};
}

}  // namespace cairn::bus
