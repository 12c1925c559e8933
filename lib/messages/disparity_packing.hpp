// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <span>

#include "core/result.hpp"
#include "messages/streams.hpp"

namespace cairn::messages {

/// A grid of disparities (0 = no answer) and of 2-bit codes, of equal size.
struct DisparityGrid {
  cv::Mat_<std::uint16_t> disparity_16ths;
  cv::Mat_<std::uint8_t> code;
};

/// Sides and number of grid points are at most these.
inline constexpr int kMaxGridSide = 4096;
inline constexpr int kMaxGridPoints = 1 << 22;

/// Packs without loss. Validity and code are one symbol of three bits, range-coded in the context
/// of its neighbours. A disparity is predicted from its left, upper and upper left neighbours
/// (median of Martucci 1990, as in LOCO-I, Weinberger et al. 2000); the errors are sorted by how
/// much the neighbours differ, two to a byte, each sort through zstd. Refuses a code over 3 and
/// sizes beyond the limits.
[[nodiscard]] Result<Bytes> pack(const DisparityGrid& grid);

/// Takes what pack gave (its first byte is 1), or a plain grid, which anybody's program can write:
/// a byte 0, then all disparities row by row (unsigned, 16 bits, low byte first), then all codes (a
/// byte each). Refuses bytes that do not give a grid of rows x columns, no more and no less.
[[nodiscard]] Result<DisparityGrid> unpack(std::span<const std::uint8_t> packed, int rows,
                                           int columns);

}  // namespace cairn::messages
