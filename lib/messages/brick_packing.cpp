// SPDX-License-Identifier: Apache-2.0
#include "messages/brick_packing.hpp"

#include <algorithm>
#include <string>
#include <tuple>

#include "messages/map_messages.hpp"

namespace cairn::messages {
namespace {

using mapping::BrickClasses;
using mapping::BrickIndex;

constexpr std::uint8_t kVersion = 1;
constexpr std::uint8_t kMixed = 3;  // in place of the one class that a whole brick has
constexpr std::size_t kClassBytes = std::tuple_size_v<decltype(BrickClasses::classes)>;
constexpr std::size_t kMaxKeyBytes = 15;

/// Four voxels of one class.
constexpr std::uint8_t four_of(std::uint8_t voxel_class) {
  return static_cast<std::uint8_t>(voxel_class * 0x55);
}

std::uint8_t kind_of(const BrickClasses& brick) {
  const std::uint8_t first = brick.classes[0];
  const bool uniform = std::all_of(brick.classes.begin(), brick.classes.end(),
                                   [first](std::uint8_t four) { return four == first; });
  const std::uint8_t voxel_class = first & 3;
  return uniform && first == four_of(voxel_class) ? voxel_class : kMixed;
}

bool has_class_3(const BrickClasses& brick) {
  return std::any_of(brick.classes.begin(), brick.classes.end(),
                     [](std::uint8_t four) { return (four & four >> 1 & 0x55) != 0; });
}

/// Signed differences, near 0 in few bytes (zigzag, then seven bits a byte).
void append_number(Bytes& bytes, std::int32_t value) {
  auto rest = static_cast<std::uint32_t>(value) << 1 ^ static_cast<std::uint32_t>(value >> 31);
  for (; rest >= 0x80; rest >>= 7) bytes.push_back(static_cast<std::uint8_t>(rest | 0x80));
  bytes.push_back(static_cast<std::uint8_t>(rest));
}

/// Reads numbers off the front; an end that comes too early or a number over 32 bits makes it bad
/// for good.
class NumberReader {
 public:
  explicit NumberReader(const Bytes& bytes) : bytes_(bytes) {}

  std::int32_t next() {
    std::uint32_t code = 0;
    for (int shift = 0; shift < 35; shift += 7) {
      if (at_ == bytes_.size()) break;
      const std::uint8_t byte = bytes_[at_++];
      code |= static_cast<std::uint32_t>(byte & 0x7f) << shift;
      if (byte < 0x80) return static_cast<std::int32_t>(code >> 1 ^ (0 - (code & 1)));
    }
    good_ = false;
    return 0;
  }
  [[nodiscard]] bool good() const { return good_; }
  [[nodiscard]] bool at_end() const { return at_ == bytes_.size(); }

 private:
  const Bytes& bytes_;
  std::size_t at_ = 0;
  bool good_ = true;
};

/// Sum that wraps round instead of overflowing: what is out of range is refused afterwards.
std::int32_t moved(std::int32_t from, std::int32_t by) {
  return static_cast<std::int32_t>(static_cast<std::uint32_t>(from) +
                                   static_cast<std::uint32_t>(by));
}

void append_move(Bytes& keys, BrickIndex from, BrickIndex to) {
  append_number(keys, to.x - from.x);
  append_number(keys, to.y - from.y);
  append_number(keys, to.z - from.z);
}

BrickIndex next_index(NumberReader& keys, BrickIndex from) {
  const std::int32_t x = moved(from.x, keys.next());
  const std::int32_t y = moved(from.y, keys.next());
  const std::int32_t z = moved(from.z, keys.next());
  return {x, y, z};
}

}  // namespace

bool packs_before(const BrickClasses& a, const BrickClasses& b) {
  return std::tie(a.level, a.brick) < std::tie(b.level, b.brick);
}

Result<void> check(const BrickClasses& brick) {
  if (!mapping::within(brick.brick, mapping::kBrickLimit)) return fail("a brick is out of range");
  if (brick.level > kMaxLevel) return fail("a brick is of level " + std::to_string(brick.level));
  if (has_class_3(brick)) return fail("a voxel is of class 3, which means nothing");
  return {};
}

Bytes pack(std::span<const BrickClasses> bricks) {
  Bytes kinds;   // level << 2 | kind
  Bytes keys;    // steps from brick to brick
  Bytes voxels;  // of bricks of more than one class
  BrickIndex previous;
  for (const BrickClasses& brick : bricks) {
    const std::uint8_t kind = kind_of(brick);
    kinds.push_back(static_cast<std::uint8_t>(brick.level << 2 | kind));
    append_move(keys, previous, brick.brick);
    previous = brick.brick;
    if (kind == kMixed) voxels.insert(voxels.end(), brick.classes.begin(), brick.classes.end());
  }
  Bytes packed{kVersion};
  StreamWriter streams(packed, Redundancy::kRepeated);
  for (const Bytes* stream : {&kinds, &keys, &voxels}) streams.append(*stream);
  return packed;
}

Result<std::vector<BrickClasses>> unpack(std::span<const std::uint8_t> packed, std::int32_t count) {
  if (count < 0 || count > kMaxBricksPacked) {
    return fail(std::to_string(count) + " bricks: out of range");
  }
  if (packed.empty() || packed[0] != kVersion) return fail("packed in an unknown version");
  const auto bricks_max = static_cast<std::size_t>(count);
  StreamReader reader(packed.subspan(1), bricks_max * (1 + kMaxKeyBytes + kClassBytes));
  const auto kinds = reader.next();
  if (!kinds) return fail(kinds.error().message);
  const auto keys = reader.next();
  if (!keys) return fail(keys.error().message);
  const auto voxels = reader.next();
  if (!voxels) return fail(voxels.error().message);
  if (!reader.at_end()) return fail("bytes after the end of the packed bricks");
  if (kinds->size() != bricks_max) return fail("not as many packed bricks as the message says");

  std::vector<BrickClasses> bricks;
  bricks.reserve(bricks_max);
  NumberReader numbers(*keys);
  std::span<const std::uint8_t> classes(*voxels);
  BrickIndex previous;
  for (const std::uint8_t level_and_kind : *kinds) {
    BrickClasses brick;
    brick.level = level_and_kind >> 2;
    brick.brick = previous = next_index(numbers, previous);
    const std::uint8_t kind = level_and_kind & 3;
    if (kind != kMixed) {
      brick.classes.fill(four_of(kind));
    } else {
      if (classes.size() < kClassBytes) return fail("packed bricks end too early");
      std::copy_n(classes.begin(), kClassBytes, brick.classes.begin());
      classes = classes.subspan(kClassBytes);
    }
    if (!numbers.good()) return fail("packed bricks end too early");
    if (const auto sound = check(brick); !sound) return fail(sound.error().message);
    if (!bricks.empty() && !packs_before(bricks.back(), brick)) {
      return fail("packed bricks are not in order");
    }
    bricks.push_back(brick);
  }
  if (!numbers.at_end() || !classes.empty()) return fail("more packed bytes than bricks");
  return bricks;
}

}  // namespace cairn::messages
