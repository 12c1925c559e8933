// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <opencv2/core.hpp>

#include "core/result.hpp"
#include "stereo/disparity_image.hpp"

namespace cairn::stereo {

/// A 16-bit grey PNG as stereo benchmarks keep it: value = disparity_px * 256, 0 = no answer. One
/// PNG pixel per grid cell; disparity stays in full-size pixels. An error if a disparity is 256 px
/// or more, which does not fit.
[[nodiscard]] Result<void> write_disparity_png(const std::filesystem::path& path,
                                               const DisparityImage& image);

/// The PNG's disparities rounded to 1/16 px (what rounds to 0 becomes 1/16), with confidence 3,
/// kNoData where the file says 0. `camera` and `step_px` are the caller's; the PNG must have one
/// pixel per grid cell.
[[nodiscard]] Result<DisparityImage> read_disparity_png(const std::filesystem::path& path,
                                                        const RectifiedCamera& camera, int step_px);

/// The PNG as floats in px, 0 = no answer: for truth, at the file's full 1/256 px.
[[nodiscard]] Result<cv::Mat_<float>> read_disparity_png_px(const std::filesystem::path& path);

}  // namespace cairn::stereo
