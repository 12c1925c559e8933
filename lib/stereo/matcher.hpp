// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <opencv2/core.hpp>
#include <string>

#include "core/config.hpp"
#include "core/result.hpp"
#include "core/time.hpp"
#include "stereo/disparity_image.hpp"

namespace cairn::stereo {

struct MatcherConfig {
  std::string method = "block";
  std::string variant = "3way";
  int min_disparity_px = 0;
  int max_disparity_px = 192;
  int downscale = 2;
  int output_step_px = 2;
  int uniqueness_percent = 10;
  int speckle_size_px = 100;

  void visit(ConfigVisitor& v) {
    v.choice("method", method, {"block", "sgm"},
             "how disparities are found: by OpenCV, or by our own semi-global matcher");
    v.choice("variant", variant, {"bm", "3way", "sgbm", "hh", "hh4"},
             "which of OpenCV's matchers, for method block");
    v.integer(
        "min_disparity_px", min_disparity_px, 0, 1024, "px",
        "smallest disparity searched, in pixels of the full image: bounds the farthest depth");
    v.integer("max_disparity_px", max_disparity_px, 16, 1024, "px",
              "disparities below this are searched, in pixels of the full image: bounds the "
              "nearest depth");
    v.integer("downscale", downscale, 1, 2, "", "2: match at half size, at an eighth of the cost");
    v.integer("output_step_px", output_step_px, 1, 2, "px",
              "every how many pixels an answer is given; 1 needs downscale 1");
    v.integer("uniqueness_percent", uniqueness_percent, 0, 50, "%",
              "by how much the best match must beat the next one");
    v.integer("speckle_size_px", speckle_size_px, 0, 10000, "px",
              "islands of disparity of at most this many pixels (of the size matched at) are "
              "dropped; 0 keeps all");
  }
};

/// Finds the disparity of each pixel of a rectified pair. A matcher keeps buffers between calls, so
/// one object serves one thread; the result depends on the arguments alone, not on what came before
/// nor on the number of threads.
class Matcher {
 public:
  virtual ~Matcher() = default;

  /// Both images CV_8UC1 and of the camera's size, rows aligned. An error says what is wrong with
  /// the images.
  ///
  /// The grid has ceil(size / step) cells. With downscale 2 a cell is the mean of full-size pixels
  /// 2c and 2c + 1, centred at 2c + 0.5; so the result's camera has cx_px and cy_px smaller by 0.5,
  /// and u = c * step holds.
  [[nodiscard]] virtual Result<DisparityImage> match(const cv::Mat& left, const cv::Mat& right,
                                                     const RectifiedCamera& camera,
                                                     Utime utime) = 0;
};

/// The matcher that `config.method` names. An error names the key whose value makes no sense beside
/// the others.
[[nodiscard]] Result<std::unique_ptr<Matcher>> make_matcher(const MatcherConfig& config);

}  // namespace cairn::stereo
