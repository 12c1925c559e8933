// SPDX-License-Identifier: Apache-2.0
#include "stereo/matched_size.hpp"

#include <opencv2/imgproc.hpp>
#include <string>

namespace cairn::stereo {
namespace {

cv::Mat half_size(const cv::Mat& image) {
  cv::Mat even = image;
  if (image.cols % 2 != 0 || image.rows % 2 != 0) {
    cv::copyMakeBorder(image, even, 0, image.rows % 2, 0, image.cols % 2, cv::BORDER_REPLICATE);
  }
  cv::Mat half;
  cv::resize(even, half, {even.cols / 2, even.rows / 2}, 0, 0, cv::INTER_AREA);
  return half;
}

template <class T>
cv::Mat_<T> every_second(const cv::Mat_<T>& full) {
  cv::Mat_<T> grid((full.rows + 1) / 2, (full.cols + 1) / 2);
  for (int row = 0; row < grid.rows; ++row) {
    for (int col = 0; col < grid.cols; ++col) grid(row, col) = full(2 * row, 2 * col);
  }
  return grid;
}

}  // namespace

Result<void> check_pair(const cv::Mat& left, const cv::Mat& right, const RectifiedCamera& camera,
                        int min_side_px) {
  if (left.empty() || right.empty()) return fail("stereo pair: an image is empty");
  if (left.type() != CV_8UC1 || right.type() != CV_8UC1) {
    return fail("stereo pair: both images must be 8-bit grey");
  }
  if (left.size() != right.size()) return fail("stereo pair: left and right differ in size");
  if (left.cols != camera.width_px || left.rows != camera.height_px) {
    return fail("stereo pair: " + std::to_string(left.cols) + "x" + std::to_string(left.rows) +
                " px, but the camera has " + std::to_string(camera.width_px) + "x" +
                std::to_string(camera.height_px));
  }
  if (left.cols < min_side_px || left.rows < min_side_px) {
    return fail("stereo pair: smaller than " + std::to_string(min_side_px) + " px");
  }
  return {};
}

cv::Mat at_matched_size(const cv::Mat& image, const MatcherConfig& config) {
  return config.downscale == 2 ? half_size(image) : image;
}

DisparityImage on_grid(const GradedPixels& graded, const MatcherConfig& config,
                       const RectifiedCamera& camera, Utime utime) {
  DisparityImage image;
  image.utime = utime;
  image.step_px = config.output_step_px;
  image.camera = camera;
  if (config.downscale == 2) {
    image.camera.cx_px -= 0.5;
    image.camera.cy_px -= 0.5;
    image.disparity_16ths = 2 * graded.disparity_16ths;
    image.code = graded.code;
  } else if (config.output_step_px == 2) {
    image.disparity_16ths = every_second(graded.disparity_16ths);
    image.code = every_second(graded.code);
  } else {
    image.disparity_16ths = graded.disparity_16ths;
    image.code = graded.code;
  }
  return image;
}

}  // namespace cairn::stereo
