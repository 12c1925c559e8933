// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <cstdlib>

namespace cairn::stereo {

/// How two pixels are compared: the signs of twelve neighbours over 9x7 against the middle (a
/// sparse census, Zabih and Woodfill 1994), and the horizontal gradient in 15 steps. A pixel is
/// four numbers of 4 bits, three of census and one of gradient; a cost is the sum of four table
/// look-ups.
inline constexpr int kDescriptorNibbles = 4;
inline constexpr int kCensusReachX_px = 4;
inline constexpr int kCensusReachY_px = 3;

struct Offset {
  int dx = 0;
  int dy = 0;
};

/// Bit i % 4 of nibble i / 4 is set where the neighbour is brighter than the middle.
inline constexpr std::array<Offset, 12> kCensusNeighbours{{{-2, -3},
                                                           {2, -3},
                                                           {-4, -1},
                                                           {0, -1},
                                                           {4, -1},
                                                           {-2, 0},
                                                           {2, 0},
                                                           {-4, 1},
                                                           {0, 1},
                                                           {4, 1},
                                                           {-2, 3},
                                                           {2, 3}}};

/// The gradient is the difference of the columns x + 1 and x - 1, each the rounded mean of its
/// middle with the rounded mean of its ends; its nibble is 8 plus or minus the count of these that
/// it reaches [grey levels over 2 px].
inline constexpr std::array<std::uint8_t, 7> kGradientSteps_grey{2, 4, 8, 14, 22, 34, 50};

inline constexpr int kCensusWeight = 2;
inline constexpr int kGradientWeight = 2;
inline constexpr int kMaxGradientCost = 10;
inline constexpr int kMaxCost = 12 * kCensusWeight + kMaxGradientCost;

using NibbleCosts = std::array<std::array<std::uint8_t, 16>, 16>;

constexpr NibbleCosts census_costs() {
  NibbleCosts costs{};
  for (unsigned a = 0; a < 16; ++a) {
    for (unsigned b = 0; b < 16; ++b) {
      const unsigned differ = a ^ b;
      const unsigned bits =
          (differ & 1) + ((differ >> 1) & 1) + ((differ >> 2) & 1) + ((differ >> 3) & 1);
      costs[a][b] = static_cast<std::uint8_t>(kCensusWeight * bits);
    }
  }
  return costs;
}

constexpr NibbleCosts gradient_costs() {
  NibbleCosts costs{};
  for (int a = 0; a < 16; ++a) {
    for (int b = 0; b < 16; ++b) {
      const int cost = kGradientWeight * (a > b ? a - b : b - a);
      costs[static_cast<std::size_t>(a)][static_cast<std::size_t>(b)] =
          static_cast<std::uint8_t>(cost < kMaxGradientCost ? cost : kMaxGradientCost);
    }
  }
  return costs;
}

}  // namespace cairn::stereo
