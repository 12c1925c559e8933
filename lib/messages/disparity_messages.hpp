// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cairn/disparity_t.hpp>
#include <cstdint>

#include "core/result.hpp"
#include "stereo/disparity_image.hpp"

namespace cairn::messages {

/// No DISPARITY or DISPARITY_BAND message is larger [bytes].
inline constexpr int kMaxDisparityMessage_bytes = 115'000;

/// The whole grid. Refuses what does not fit kMaxDisparityMessage_bytes, codes over 3 and grids
/// that are not those of their camera.
[[nodiscard]] Result<disparity_t> to_message(const stereo::DisparityImage& image,
                                             std::uint64_t calibration_id);

/// Rows [first_row, first_row + row_count) of the grid, for DISPARITY_BAND.
[[nodiscard]] Result<disparity_t> to_band_message(const stereo::DisparityImage& image,
                                                  std::uint64_t calibration_id, int first_row,
                                                  int row_count);

/// Without loss, but for T_body_camera, which comes as_sent. A band is an image of its own: its
/// camera looks at the band alone (cy_px is counted from its first row, height_px ends with its
/// last). Refuses, naming the field, what does not add up.
[[nodiscard]] Result<stereo::DisparityImage> to_disparity(const disparity_t& message);

}  // namespace cairn::messages
