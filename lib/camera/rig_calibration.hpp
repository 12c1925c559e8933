// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "core/geometry.hpp"
#include "core/result.hpp"

namespace cairn::camera {

/// How a lens bends: the coefficient order is OpenCV's.
enum class Distortion {
  kNone,              ///< no coefficients
  kRadialTangential,  ///< k1 k2 p1 p2 [k3 [k4 k5 k6]] (Brown 1966)
  kEquidistant,       ///< k1 k2 k3 k4 (Kannala and Brandt 2006)
};

/// One pinhole camera; pixel centres at whole numbers.
struct CameraModel {
  double fx_px = 0;
  double fy_px = 0;
  double cx_px = 0;
  double cy_px = 0;
  Distortion distortion = Distortion::kNone;
  std::vector<double> coefficients;

  [[nodiscard]] cv::Matx33d K() const { return {fx_px, 0, cx_px, 0, fy_px, cy_px, 0, 0, 1}; }
};

/// Two cameras fixed to one body.
struct RigCalibration {
  std::uint64_t id =
      0;  ///< content hash (calibration_id); a frame names the calibration that it was taken with
  int width_px = 0;
  int height_px = 0;
  CameraModel left;
  CameraModel right;
  Isometry T_right_left =
      Isometry::Identity();  ///< for a horizontal rectified rig: translation (-baseline, 0, 0)
  Isometry T_body_left = Isometry::Identity();
  bool rectified = false;  ///< images are already row-aligned and free of distortion

  [[nodiscard]] double baseline_m() const { return T_right_left.translation().norm(); }
};

/// Hash of all that the calibration says, itself excluded; never 0.
[[nodiscard]] std::uint64_t calibration_id(const RigCalibration& rig);

/// Nothing if the numbers can belong to a real rig (finite, positive focal lengths and size, proper
/// rotations, a baseline over 1 mm, the coefficient count of the model), else what is wrong.
[[nodiscard]] Result<void> check(const RigCalibration& rig);

/// A rectified rig from the numbers of a dataset: both cameras alike, right camera baseline_m to
/// the right.
[[nodiscard]] RigCalibration rectified_rig(double fx_px, double fy_px, double cx_px, double cy_px,
                                           double baseline_m, int width_px, int height_px,
                                           const Isometry& T_body_left);

/// Loads and saves the rig file of config/calibration/*.yaml (format:
/// config/calibration/README.md).
[[nodiscard]] Result<RigCalibration> load_rig(const std::string& path);
[[nodiscard]] Result<void> save_rig(const std::string& path, const RigCalibration& rig);

}  // namespace cairn::camera
