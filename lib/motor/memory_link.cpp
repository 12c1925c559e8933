// SPDX-License-Identifier: Apache-2.0
#include "motor/memory_link.hpp"

#include <array>
#include <cstddef>
#include <deque>
#include <limits>
#include <mutex>

namespace cairn::motor {
namespace {

constexpr std::size_t kMaxWaiting_bytes = 65'536;

struct Portion {
  HostTime written_us;
  std::vector<std::uint8_t> bytes;
};

/// The bytes on their way, in both directions.
struct Line {
  std::mutex mutex;
  std::function<HostTime()> now_us;
  std::array<std::deque<Portion>, 2> to_end;
  std::array<std::size_t, 2> waiting_bytes{};
  std::array<bool, 2> open{true, true};
};

class MemoryLink : public ByteLink {
 public:
  MemoryLink(std::shared_ptr<Line> line, std::size_t end) : line_{std::move(line)}, end_{end} {}

  ~MemoryLink() override {
    const std::lock_guard lock{line_->mutex};
    line_->open[end_] = false;
  }

  [[nodiscard]] Result<std::vector<std::uint8_t>> read() override {
    const std::lock_guard lock{line_->mutex};
    std::deque<Portion>& portions = line_->to_end[end_];
    const HostTime before_us =
        line_->now_us ? line_->now_us() : std::numeric_limits<HostTime>::max();
    std::vector<std::uint8_t> bytes;
    while (!portions.empty() && portions.front().written_us < before_us) {
      const auto& next = portions.front().bytes;
      bytes.insert(bytes.end(), next.begin(), next.end());
      portions.pop_front();
    }
    line_->waiting_bytes[end_] -= bytes.size();
    if (bytes.empty() && portions.empty() && !line_->open[other()])
      return fail("memory line: the other end is closed");
    return bytes;
  }

  [[nodiscard]] Result<void> write(std::span<const std::uint8_t> bytes) override {
    const std::lock_guard lock{line_->mutex};
    if (!line_->open[other()]) return fail("memory line: the other end is closed");
    if (line_->waiting_bytes[other()] + bytes.size() > kMaxWaiting_bytes)
      return fail("memory line: full");
    const HostTime now_us = line_->now_us ? line_->now_us() : 0;
    line_->to_end[other()].push_back({now_us, {bytes.begin(), bytes.end()}});
    line_->waiting_bytes[other()] += bytes.size();
    return {};
  }

 private:
  [[nodiscard]] std::size_t other() const { return 1 - end_; }

  std::shared_ptr<Line> line_;
  std::size_t end_;
};

}  // namespace

std::pair<std::unique_ptr<ByteLink>, std::unique_ptr<ByteLink>> make_memory_links(
    std::function<HostTime()> now_us) {
  auto line = std::make_shared<Line>();
  line->now_us = std::move(now_us);
  return {std::make_unique<MemoryLink>(line, 0), std::make_unique<MemoryLink>(line, 1)};
}

}  // namespace cairn::motor
