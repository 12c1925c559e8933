// SPDX-License-Identifier: Apache-2.0
#include "planning/plan_memory.hpp"

#include <algorithm>
#include <cmath>

#include "mapping/byte_stream.hpp"

namespace cairn::planning {
namespace {

constexpr std::uint32_t kMagic = 0x314e4c50;  // "PLN1"
constexpr double kFarthest_m = 1e6;
constexpr double kLargestRadius_m = 5;
constexpr std::size_t kLongestReason = 500;
constexpr std::uint8_t kMostLooks = 100;

class Reader {
 public:
  explicit Reader(std::span<const std::uint8_t> bytes) : bytes_{bytes} {}

  template <class T>
  T take() {
    T value{};
    good_ = good_ && bytes_.get(value);
    return value;
  }
  double take_within(double most) {
    const auto value = take<double>();
    good_ = good_ && std::abs(value) <= most;  // false for NaN
    return value;
  }
  template <class T>
  T take_up_to(T most) {
    const auto value = take<std::uint8_t>();
    good_ = good_ && value <= static_cast<std::uint8_t>(most);
    return static_cast<T>(value);
  }
  /// A count of things of at least so many bytes each.
  std::uint32_t take_count(std::size_t bytes_each) {
    const auto count = take<std::uint32_t>();
    good_ = good_ && count <= bytes_.left() / bytes_each;
    return good_ ? count : 0;
  }
  std::string take_text() {
    std::span<const std::uint8_t> text;
    good_ = good_ && bytes_.get_bytes(take_count(1), text);
    good_ = good_ && text.size() <= kLongestReason;
    return good_ ? std::string(text.begin(), text.end()) : std::string();
  }
  [[nodiscard]] bool good() const { return good_; }
  [[nodiscard]] bool at_end() const { return bytes_.left() == 0; }

 private:
  mapping::ByteReader bytes_;
  bool good_ = true;
};

}  // namespace

std::vector<std::uint8_t> to_bytes(const PlanMemory& memory) {
  mapping::ByteWriter bytes;
  bytes.put(kMagic);
  bytes.put(static_cast<std::uint8_t>(memory.mission));
  bytes.put(memory.goal_id);
  bytes.put(memory.destination.at_m.x());
  bytes.put(memory.destination.at_m.y());
  bytes.put(static_cast<std::uint8_t>(memory.destination.heading_rad.has_value()));
  bytes.put(memory.destination.heading_rad.value_or(0));
  bytes.put(static_cast<std::uint8_t>(memory.looked_round));
  bytes.put(static_cast<std::uint8_t>(memory.phase));
  const std::size_t length = std::min(memory.reason.size(), kLongestReason);
  bytes.put(static_cast<std::uint32_t>(length));
  for (std::size_t i = 0; i < length; ++i) bytes.put(static_cast<std::uint8_t>(memory.reason[i]));
  bytes.put(static_cast<std::uint32_t>(memory.floor.size()));
  for (const KnownFloor& floor : memory.floor) {
    for (const double number : {floor.at_m.x(), floor.at_m.y(), floor.radius_m, floor.height_m})
      bytes.put(number);
  }
  bytes.put(static_cast<std::uint32_t>(memory.looks.size()));
  for (const auto& [cell, looks] : memory.looks) {
    bytes.put(cell.x);
    bytes.put(cell.y);
    bytes.put(looks);
  }
  return bytes.take();
}

Result<PlanMemory> plan_memory_from_bytes(std::span<const std::uint8_t> bytes) {
  Reader reader(bytes);
  if (reader.take<std::uint32_t>() != kMagic) return fail("plan memory: wrong magic word");
  PlanMemory memory;
  memory.mission = reader.take_up_to(Mission::kExplore);
  memory.goal_id = reader.take<std::int64_t>();
  memory.destination.at_m.x() = reader.take_within(kFarthest_m);
  memory.destination.at_m.y() = reader.take_within(kFarthest_m);
  const bool has_heading = reader.take_up_to<std::uint8_t>(1) != 0;
  const double heading_rad = reader.take_within(kFarthest_m);
  if (has_heading) memory.destination.heading_rad = heading_rad;
  memory.looked_round = reader.take_up_to<std::uint8_t>(1) != 0;
  memory.phase = reader.take_up_to(Phase::kRefused);
  memory.reason = reader.take_text();
  memory.floor.resize(reader.take_count(4 * sizeof(double)));
  for (KnownFloor& floor : memory.floor) {
    floor.at_m.x() = reader.take_within(kFarthest_m);
    floor.at_m.y() = reader.take_within(kFarthest_m);
    floor.radius_m = reader.take_within(kLargestRadius_m);
    floor.height_m = reader.take_within(kFarthest_m);
  }
  for (std::uint32_t left = reader.take_count(2 * sizeof(std::int32_t) + 1); left > 0; --left) {
    const auto x = reader.take<std::int32_t>();
    const auto y = reader.take<std::int32_t>();
    memory.looks[{x, y}] = reader.take_up_to(kMostLooks);
  }
  if (!reader.good()) return fail("plan memory: too short, or a number out of range");
  if (!reader.at_end()) return fail("plan memory: bytes left over");
  return memory;
}

}  // namespace cairn::planning
