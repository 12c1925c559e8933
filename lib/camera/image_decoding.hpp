// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <opencv2/core.hpp>
#include <span>
#include <vector>

#include "core/result.hpp"

namespace cairn::camera {

/// An encoded 8-bit image (PNG, JPEG, ...) as CV_8UC1; colour becomes grey (ITU-R BT.601 weights).
/// Refused with a reason: what does not decode, what ends early, 16-bit images. Damage in the
/// middle of a JPEG cannot be told.
[[nodiscard]] Result<cv::Mat> decode_grey(std::span<const std::uint8_t> bytes);

/// The same for a file; the error names it.
[[nodiscard]] Result<cv::Mat> read_grey_image(const std::filesystem::path& file);

/// A 16-bit one-channel image as CV_32FC1 metres: value * scale_m, and 0 for every value in
/// `invalid`.
[[nodiscard]] Result<cv::Mat> read_depth_image(const std::filesystem::path& file, double scale_m,
                                               const std::vector<int>& invalid);

}  // namespace cairn::camera
