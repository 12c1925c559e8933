// SPDX-License-Identifier: Apache-2.0
#include "camera/rig_calibration.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "core/checksum.hpp"

namespace cairn::camera {
namespace {

constexpr double kMinBaseline_m = 1e-3;
constexpr double kMaxSize_px = 32768;
constexpr double kRotationTolerance = 1e-6;

/// The canonical bytes of a calibration: every number as 64 bits, little end first, zero without a
/// sign.
class CanonicalBytes {
 public:
  void add(std::uint64_t bits) {
    for (int shift = 0; shift < 64; shift += 8) {
      bytes_.push_back(static_cast<std::uint8_t>(bits >> shift));
    }
  }
  void add(double value) { add(std::bit_cast<std::uint64_t>(value == 0 ? 0.0 : value)); }
  void add(const CameraModel& camera) {
    for (const double value : {camera.fx_px, camera.fy_px, camera.cx_px, camera.cy_px}) add(value);
    add(static_cast<std::uint64_t>(camera.distortion));
    add(static_cast<std::uint64_t>(camera.coefficients.size()));
    for (const double value : camera.coefficients) add(value);
  }
  void add(const Isometry& T) {
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 4; ++column) add(T.matrix()(row, column));
    }
  }
  [[nodiscard]] const std::vector<std::uint8_t>& bytes() const { return bytes_; }

 private:
  std::vector<std::uint8_t> bytes_;
};

bool count_fits(Distortion distortion, std::size_t count) {
  switch (distortion) {
    case Distortion::kNone:
      return count == 0;
    case Distortion::kRadialTangential:
      return count == 4 || count == 5 || count == 8;
    case Distortion::kEquidistant:
      return count == 4;
  }
  return false;
}

Result<void> check_camera(const std::string& name, const CameraModel& camera) {
  const auto positive = [](double value) { return std::isfinite(value) && value > 0; };
  if (!positive(camera.fx_px)) return fail(name + ".fx_px: is not a positive number");
  if (!positive(camera.fy_px)) return fail(name + ".fy_px: is not a positive number");
  if (!std::isfinite(camera.cx_px)) return fail(name + ".cx_px: is not a finite number");
  if (!std::isfinite(camera.cy_px)) return fail(name + ".cy_px: is not a finite number");
  if (!count_fits(camera.distortion, camera.coefficients.size())) {
    return fail(name + ".coefficients: " + std::to_string(camera.coefficients.size()) +
                " given, but the distortion model takes another number (none: 0, "
                "radial-tangential: 4, 5 or 8, equidistant: 4)");
  }
  const auto finite = [](double value) { return std::isfinite(value); };
  if (!std::all_of(camera.coefficients.begin(), camera.coefficients.end(), finite)) {
    return fail(name + ".coefficients: holds a number that is not finite");
  }
  return {};
}

Result<void> check_pose(const std::string& name, const Isometry& T) {
  if (!T.matrix().allFinite()) return fail(name + ": holds a number that is not finite");
  const Eigen::Matrix3d R = T.linear();
  const double error = (R.transpose() * R - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  if (error > kRotationTolerance) return fail(name + ": its rotation is not orthonormal");
  if (R.determinant() < 0) return fail(name + ": its rotation mirrors (determinant -1)");
  return {};
}

/// The second camera must be to the right of the first, or below it in a vertical rig: a swapped
/// pair or a negated translation has no answer in any matcher.
Result<void> check_baseline(const RigCalibration& rig) {
  const Eigen::Vector3d t_m = rig.T_right_left.translation();
  if (rig.baseline_m() < kMinBaseline_m) return fail("T_right_left: the baseline is under 1 mm");
  Eigen::Index axis = 0;
  t_m.cwiseAbs().maxCoeff(&axis);
  if (axis == 2) return fail("T_right_left: one camera stands behind the other");
  if (t_m[axis] > 0) {
    return fail(std::string("T_right_left: the right camera stands ") +
                (axis == 0 ? "left of" : "above") + " the left one: are they swapped?");
  }
  if (!rig.rectified) return {};
  const double off_axis_m = std::hypot(t_m[axis == 0 ? 1 : 0], t_m[2]);
  if (off_axis_m > kRotationTolerance * rig.baseline_m() ||
      rotation_angle_rad(rig.T_right_left.linear()) > kRotationTolerance) {
    return fail("T_right_left: a rectified rig has no rotation and is shifted along one axis");
  }
  return {};
}

}  // namespace

std::uint64_t calibration_id(const RigCalibration& rig) {
  CanonicalBytes canonical;
  canonical.add(static_cast<std::uint64_t>(rig.width_px));
  canonical.add(static_cast<std::uint64_t>(rig.height_px));
  canonical.add(rig.left);
  canonical.add(rig.right);
  canonical.add(rig.T_right_left);
  canonical.add(rig.T_body_left);
  canonical.add(static_cast<std::uint64_t>(rig.rectified ? 1 : 0));
  return std::max<std::uint64_t>(1, fnv1a_64(canonical.bytes()));
}

Result<void> check(const RigCalibration& rig) {
  for (const int size_px : {rig.width_px, rig.height_px}) {
    if (size_px < 1 || size_px > kMaxSize_px) {
      return fail("width_px, height_px: " + std::to_string(rig.width_px) + " x " +
                  std::to_string(rig.height_px) + " is not the size of an image");
    }
  }
  if (auto left = check_camera("left", rig.left); !left) return left;
  if (auto right = check_camera("right", rig.right); !right) return right;
  if (auto pose = check_pose("T_right_left", rig.T_right_left); !pose) return pose;
  if (auto pose = check_pose("T_body_left", rig.T_body_left); !pose) return pose;
  if (rig.rectified &&
      (rig.left.distortion != Distortion::kNone || rig.right.distortion != Distortion::kNone)) {
    return fail("rectified: true, but a camera has a distortion");
  }
  return check_baseline(rig);
}

RigCalibration rectified_rig(double fx_px, double fy_px, double cx_px, double cy_px,
                             double baseline_m, int width_px, int height_px,
                             const Isometry& T_body_left) {
  RigCalibration rig;
  rig.width_px = width_px;
  rig.height_px = height_px;
  rig.left = CameraModel{fx_px, fy_px, cx_px, cy_px, Distortion::kNone, {}};
  rig.right = rig.left;
  rig.T_right_left.translation() = Eigen::Vector3d(-baseline_m, 0, 0);
  rig.T_body_left = T_body_left;
  rig.rectified = true;
  rig.id = calibration_id(rig);
  return rig;
}

}  // namespace cairn::camera
