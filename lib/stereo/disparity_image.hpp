// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>

#include "core/geometry.hpp"
#include "core/time.hpp"

namespace cairn::stereo {

/// Why a pixel has no disparity. Values are what goes over the bus.
enum class Reason : std::uint8_t {
  kNoData = 0,      ///< outside the other image, covered, or rejected as a speckle
  kLowTexture = 1,  ///< nothing there to match
  kAmbiguous = 2,   ///< failed the uniqueness or the left-right check
  kOutOfRange = 3,  ///< nearer or farther than was searched
};

/// The rectified left camera that a disparity image belongs to: square pixels, no distortion.
struct RectifiedCamera {
  double f_px = 0;
  double cx_px = 0;
  double cy_px = 0;
  /// cx of the right camera less cx of the left [px]: depth = f * baseline / (disparity + doffs).
  double doffs_px = 0;
  double baseline_m = 0;
  int width_px = 0;   ///< of the full image
  int height_px = 0;  ///< of the full image
  Isometry T_body_camera = Isometry::Identity();
};

/// One answer for every step_px-th pixel of every step_px-th row: grid (row r, column c) belongs to
/// full-size pixel (u, v) = (c * step_px, r * step_px); disparity is in full-size pixels.
struct DisparityImage {
  Utime utime = 0;
  int step_px = 1;
  RectifiedCamera camera;
  cv::Mat_<std::uint16_t> disparity_16ths;  ///< 1/16 px; 0 = no answer
  /// Where there is an answer: confidence 0 (least) to 3. Where there is none: a Reason.
  cv::Mat_<std::uint8_t> code;

  [[nodiscard]] int rows() const { return disparity_16ths.rows; }
  [[nodiscard]] int cols() const { return disparity_16ths.cols; }
  [[nodiscard]] bool valid(int row, int col) const { return disparity_16ths(row, col) != 0; }
  [[nodiscard]] double disparity_px(int row, int col) const {
    return disparity_16ths(row, col) / 16.0;
  }
  /// Depth along the optical axis [m]; the pixel must be valid. Inf where disparity + doffs is not
  /// positive.
  [[nodiscard]] double depth_m(int row, int col) const;
  /// The point in the rectified left camera's frame [m]; the pixel must be valid.
  [[nodiscard]] Eigen::Vector3d point_camera(int row, int col) const;
};

}  // namespace cairn::stereo
