// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <bit>
#include <compare>
#include <cstddef>
#include <cstdint>

namespace cairn::mapping {

/// A cell of a regular grid; sorts by x, then y, then z.
template <class Tag>
struct GridIndex {
  std::int32_t x = 0;
  std::int32_t y = 0;
  std::int32_t z = 0;
  friend constexpr auto operator<=>(const GridIndex&, const GridIndex&) = default;
};

/// Voxel (x, y, z) fills [x, x+1) * resolution along each axis of the map frame. A brick is 8 x 8 x
/// 8 voxels, a tile 16 x 16 x 16 bricks; both are aligned at the origin.
using VoxelIndex = GridIndex<struct VoxelTag>;
using BrickIndex = GridIndex<struct BrickTag>;
using TileIndex = GridIndex<struct TileTag>;

inline constexpr int kBrickSide = 8;
inline constexpr int kBrickVoxels = kBrickSide * kBrickSide * kBrickSide;
inline constexpr int kTileSide = 16;
inline constexpr int kTileBricks = kTileSide * kTileSide * kTileSide;

/// Grid coordinates lie in [-limit, limit): at 1 cm some 80 km each way.
inline constexpr std::int32_t kVoxelLimit = 1 << 23;
inline constexpr std::int32_t kBrickLimit = kVoxelLimit / kBrickSide;
inline constexpr std::int32_t kTileLimit = kBrickLimit / kTileSide;

template <class Tag>
[[nodiscard]] constexpr bool within(const GridIndex<Tag>& index, std::int32_t limit) {
  const auto inside = [limit](std::int32_t value) { return value >= -limit && value < limit; };
  return inside(index.x) && inside(index.y) && inside(index.z);
}

[[nodiscard]] constexpr BrickIndex brick_of(VoxelIndex v) { return {v.x >> 3, v.y >> 3, v.z >> 3}; }
[[nodiscard]] constexpr TileIndex tile_of(BrickIndex b) { return {b.x >> 4, b.y >> 4, b.z >> 4}; }

/// A voxel's place among its brick's 512: x fastest, then y, then z.
[[nodiscard]] constexpr int index_in_brick(VoxelIndex v) {
  return (v.x & 7) | (v.y & 7) << 3 | (v.z & 7) << 6;
}
/// A brick's place among its tile's 4096: x fastest, then y, then z.
[[nodiscard]] constexpr int index_in_tile(BrickIndex b) {
  return (b.x & 15) | (b.y & 15) << 4 | (b.z & 15) << 8;
}
[[nodiscard]] constexpr VoxelIndex voxel_in(BrickIndex b, int index) {
  return {b.x * kBrickSide + (index & 7), b.y * kBrickSide + (index >> 3 & 7),
          b.z * kBrickSide + (index >> 6)};
}
[[nodiscard]] constexpr BrickIndex brick_in(TileIndex t, int index) {
  return {t.x * kTileSide + (index & 15), t.y * kTileSide + (index >> 4 & 15),
          t.z * kTileSide + (index >> 8)};
}

/// Coordinates in [-2^20, 2^20) as one number that sorts as they do.
template <class Tag>
[[nodiscard]] constexpr std::uint64_t packed(const GridIndex<Tag>& index) {
  constexpr auto field = [](std::int32_t value) {
    return static_cast<std::uint64_t>(value + kBrickLimit) & 0x1fffff;
  };
  return field(index.x) << 42 | field(index.y) << 21 | field(index.z);
}

/// One bit for each voxel of a brick: word z holds bit x + 8 y.
struct VoxelMask {
  std::array<std::uint64_t, kBrickSide> words{};

  [[nodiscard]] static VoxelMask all() {
    VoxelMask mask;
    mask.words.fill(~std::uint64_t{0});
    return mask;
  }
  [[nodiscard]] bool test(int index) const {
    return (words[static_cast<std::size_t>(index >> 6)] >> (index & 63) & 1) != 0;
  }
  void set(int index) {
    words[static_cast<std::size_t>(index >> 6)] |= std::uint64_t{1} << (index & 63);
  }
  [[nodiscard]] bool any() const {
    std::uint64_t all = 0;
    for (const std::uint64_t word : words) all |= word;
    return all != 0;
  }
  [[nodiscard]] int count() const {
    int sum = 0;
    for (const std::uint64_t word : words) sum += std::popcount(word);
    return sum;
  }
  friend bool operator==(const VoxelMask&, const VoxelMask&) = default;
};

/// Calls visit(index in 0..511) for every set bit, rising.
template <class Visit>
void for_each_voxel(const VoxelMask& mask, Visit&& visit) {
  for (int z = 0; z < kBrickSide; ++z) {
    for (std::uint64_t bits = mask.words[static_cast<std::size_t>(z)]; bits != 0;
         bits &= bits - 1) {
      visit(z << 6 | std::countr_zero(bits));
    }
  }
}

}  // namespace cairn::mapping
