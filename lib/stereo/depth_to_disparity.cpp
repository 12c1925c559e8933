// SPDX-License-Identifier: Apache-2.0
#include "stereo/depth_to_disparity.hpp"

#include <cmath>
#include <limits>
#include <string>

namespace cairn::stereo {
namespace {

constexpr double kMax16ths = std::numeric_limits<std::uint16_t>::max();
constexpr std::uint8_t kFullConfidence = 3;

}  // namespace

Result<DisparityImage> disparity_from_depth(const cv::Mat& depth_m, const RectifiedCamera& camera,
                                            int step_px, Utime utime) {
  if (depth_m.type() != CV_32FC1 || depth_m.empty()) {
    return fail("depth image: must be one channel of 32-bit floats and not empty");
  }
  if (depth_m.cols != camera.width_px || depth_m.rows != camera.height_px) {
    return fail("depth image: " + std::to_string(depth_m.cols) + "x" +
                std::to_string(depth_m.rows) + " px, but the camera has " +
                std::to_string(camera.width_px) + "x" + std::to_string(camera.height_px));
  }
  if (step_px < 1) return fail("step_px: must be at least 1, is " + std::to_string(step_px));
  const double fb = camera.f_px * camera.baseline_m;
  if (!(fb > 0) || !std::isfinite(fb)) return fail("camera: f_px * baseline_m must be positive");

  DisparityImage image{
      .utime = utime, .step_px = step_px, .camera = camera, .disparity_16ths = {}, .code = {}};
  const cv::Size size{(depth_m.cols + step_px - 1) / step_px,
                      (depth_m.rows + step_px - 1) / step_px};
  image.disparity_16ths = cv::Mat_<std::uint16_t>::zeros(size);
  image.code = cv::Mat_<std::uint8_t>(size, static_cast<std::uint8_t>(Reason::kNoData));
  for (int row = 0; row < size.height; ++row) {
    const auto* depth_row = depth_m.ptr<float>(row * step_px);
    for (int col = 0; col < size.width; ++col) {
      const double z_m = static_cast<double>(depth_row[col * step_px]);
      if (!std::isfinite(z_m) || !(z_m > 0)) continue;
      const double rounded = std::round(16.0 * (fb / z_m - camera.doffs_px));
      if (rounded < 1 || rounded > kMax16ths) {
        image.code(row, col) = static_cast<std::uint8_t>(Reason::kOutOfRange);
        continue;
      }
      image.disparity_16ths(row, col) = static_cast<std::uint16_t>(rounded);
      image.code(row, col) = kFullConfidence;
    }
  }
  return image;
}

}  // namespace cairn::stereo
