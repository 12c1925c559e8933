// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <span>

#include "core/result.hpp"
#include "messages/streams.hpp"

namespace cairn::messages {

/// Symbols of three bits, one a grid point, with a frame of zeros: one row above, one column on the
/// left, two on the right.
using SymbolGrid = cv::Mat_<std::uint8_t>;

/// Range-codes the symbols inside the frame, each in the context of those to the left, above and
/// above right.
[[nodiscard]] Bytes encode_symbols(const SymbolGrid& symbols);

/// Refuses bytes that are too few or too many.
[[nodiscard]] Result<SymbolGrid> decode_symbols(std::span<const std::uint8_t> bytes, int rows,
                                                int columns);

/// A grid of rows x columns in its frame, all zero; element (row, column) is at (row + 1, column +
/// 1).
template <class T>
[[nodiscard]] cv::Mat_<T> framed(int rows, int columns) {
  return cv::Mat_<T>(rows + 1, columns + 3, T{0});
}

}  // namespace cairn::messages
