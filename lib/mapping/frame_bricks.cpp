// SPDX-License-Identifier: Apache-2.0
#include "mapping/frame_bricks.hpp"

namespace cairn::mapping {
namespace {

using Words = std::array<std::uint64_t, kBrickSide>;

/// Swaps the bits of `high` under mask << shift with the bits of `low` under mask.
void swap_bits(std::uint64_t& high, std::uint64_t& low, int shift, std::uint64_t mask) {
  const std::uint64_t differ = (high ^ low >> shift) & mask;
  high ^= differ;
  low ^= differ << shift;
}

/// Byte j of word i becomes byte i of word j (Warren 2012, Hacker's Delight, 7-3).
Words transposed_bytes(Words words) {
  for (const std::size_t i : {0, 1, 2, 3}) swap_bits(words[i + 4], words[i], 32, 0xffffffff);
  for (const std::size_t i : {0, 1, 4, 5})
    swap_bits(words[i + 2], words[i], 16, 0x0000ffff0000ffffULL);
  for (const std::size_t i : {0, 2, 4, 6})
    swap_bits(words[i + 1], words[i], 8, 0x00ff00ff00ff00ffULL);
  return words;
}

/// Bit j of byte i becomes bit i of byte j (the same).
std::uint64_t transposed_bits(std::uint64_t word) {
  const auto swap_within = [&word](int shift, std::uint64_t mask) {
    const std::uint64_t differ = (word ^ word >> shift) & mask;
    word ^= differ ^ differ << shift;
  };
  swap_within(7, 0x00aa00aa00aa00aaULL);
  swap_within(14, 0x0000cccc0000ccccULL);
  swap_within(28, 0x00000000f0f0f0f0ULL);
  return word;
}

}  // namespace

VoxelMask MissLayers::mask() const {
  const Words along_x = transposed_bytes(words[0]);
  const Words along_y = transposed_bytes(words[1]);
  VoxelMask mask;
  for (std::size_t z = 0; z < kBrickSide; ++z) {
    mask.words[z] = transposed_bits(along_x[z]) | along_y[z] | words[2][z];
  }
  return mask;
}

}  // namespace cairn::mapping
