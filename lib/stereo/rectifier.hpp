// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>

#include "camera/rig_calibration.hpp"
#include "core/result.hpp"
#include "stereo/disparity_image.hpp"

namespace cairn::stereo {

struct RectifiedPair {
  cv::Mat left;
  cv::Mat right;
};

/// Turns the images of a rig into images whose rows correspond. Both cameras are turned so that
/// their x axes lie along the baseline (Fusiello, Trucco and Verri 2000), with the mean of their
/// viewing directions; so a rig with one camera above the other comes out lying on its side, and
/// its left image's x axis points at the second camera.
///
/// The rectified focal length is the smallest that leaves no pixel without a picture in either
/// camera, as far as the images' edges tell. A rig that says it is rectified, and is so by its
/// numbers, passes its images through.
class Rectifier {
 public:
  /// An error if camera::check refuses the rig, or if its cameras look over 60 degrees apart, along
  /// the baseline, or at nothing in common.
  [[nodiscard]] static Result<Rectifier> create(const camera::RigCalibration& rig);

  [[nodiscard]] const RectifiedCamera& camera() const { return camera_; }
  [[nodiscard]] bool passes_through() const { return left_.map.empty(); }

  /// Both images CV_8UC1 of the rig's size. Passed through, the result shares the arguments'
  /// memory.
  [[nodiscard]] Result<RectifiedPair> rectify(const cv::Mat& left, const cv::Mat& right) const;

 private:
  struct Remap {
    cv::Mat map;        ///< CV_16SC2; empty: the images pass through
    cv::Mat fractions;  ///< CV_16UC1
  };

  Rectifier() = default;

  RectifiedCamera camera_;
  cv::Size raw_size_;
  Remap left_;
  Remap right_;
};

}  // namespace cairn::stereo
