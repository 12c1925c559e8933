// SPDX-License-Identifier: Apache-2.0
#include "core/state_folder.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "core/atomic_file.hpp"
#include "core/checksum.hpp"

namespace cairn {
namespace {

struct SlotHeader {
  std::uint64_t sequence;
  std::uint64_t size;
  std::uint64_t checksum;
};

struct Slot {
  std::uint64_t sequence = 0;
  std::vector<std::uint8_t> bytes;
};

std::filesystem::path slot_path(const std::filesystem::path& base, int slot) {
  return base.string() + (slot == 0 ? ".a" : ".b");
}

std::optional<Slot> read_slot(const std::filesystem::path& path) {
  const auto file = read_file(path, std::size_t{1} << 26);
  SlotHeader header{};
  if (!file || file->size() < sizeof(header)) return std::nullopt;
  std::memcpy(&header, file->data(), sizeof(header));
  if (header.size > file->size() - sizeof(header)) return std::nullopt;
  const std::span<const std::uint8_t> payload{file->data() + sizeof(header),
                                              static_cast<std::size_t>(header.size)};
  if (fnv1a_64(payload, header.sequence) != header.checksum) return std::nullopt;
  return Slot{header.sequence, {payload.begin(), payload.end()}};
}

}  // namespace

Result<StateFolder> StateFolder::open(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) return fail(folder.string() + ": cannot make the state folder: " + error.message());
  const std::filesystem::path file = folder / "lock";
  const int fd = ::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  if (fd < 0) return fail(file.string() + ": cannot write: " + std::strerror(errno));
  const std::shared_ptr<const int> lock(new int(fd), [](const int* held) {
    ::close(*held);
    delete held;
  });
  if (::flock(fd, LOCK_EX | LOCK_NB) != 0) {
    return fail(folder.string() + ": is the state folder of a process that is running");
  }
  return StateFolder{folder, lock};
}

std::filesystem::path StateFolder::path(const std::string& name) const {
  return enabled() ? folder_ / name : std::filesystem::path{};
}

Result<void> StateFolder::save(const std::string& name, std::span<const std::uint8_t> bytes) const {
  if (!enabled()) return {};
  const auto a = read_slot(slot_path(path(name), 0));
  const auto b = read_slot(slot_path(path(name), 1));
  const std::uint64_t last_a = a ? a->sequence : 0;
  const std::uint64_t last_b = b ? b->sequence : 0;
  const SlotHeader header{std::max(last_a, last_b) + 1, bytes.size(),
                          fnv1a_64(bytes, std::max(last_a, last_b) + 1)};
  const std::filesystem::path target = slot_path(path(name), last_a <= last_b ? 0 : 1);
  std::vector<std::uint8_t> file(sizeof(header) + bytes.size());
  std::memcpy(file.data(), &header, sizeof(header));
  if (!bytes.empty()) std::memcpy(file.data() + sizeof(header), bytes.data(), bytes.size());
  const int fd = ::open(target.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0644);
  if (fd < 0) return fail(target.string() + ": cannot write: " + std::strerror(errno));
  const ssize_t written = ::pwrite(fd, file.data(), file.size(), 0);
  const int problem = errno;
  ::close(fd);
  if (written != static_cast<ssize_t>(file.size())) {
    return fail(target.string() +
                ": cannot write: " + (written < 0 ? std::strerror(problem) : "no room left"));
  }
  return {};
}

std::optional<std::vector<std::uint8_t>> StateFolder::load(const std::string& name) const {
  if (!enabled()) return std::nullopt;
  auto a = read_slot(slot_path(path(name), 0));
  auto b = read_slot(slot_path(path(name), 1));
  if (!a && !b) return std::nullopt;
  if (!b || (a && a->sequence > b->sequence)) return std::move(a->bytes);
  return std::move(b->bytes);
}

}  // namespace cairn
