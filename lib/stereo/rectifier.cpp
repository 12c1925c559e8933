// SPDX-License-Identifier: Apache-2.0
#include "stereo/rectifier.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/calib3d.hpp>
#include <opencv2/core/eigen.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

namespace cairn::stereo {
namespace {

using camera::CameraModel;
using camera::Distortion;
using camera::RigCalibration;

constexpr double kAlignedTolerance = 1e-6;
constexpr double kMinCosBetweenViews = 0.5;
constexpr double kMinSinViewToBaseline = 0.5;
constexpr double kMinViewWidth = 1e-3;
constexpr double kZoomStep = 1.002;  // hides what the edge samples miss
constexpr int kMaxZoomSteps = 40;
constexpr int kSamplesPerEdge = 64;

bool is_row_aligned(const RigCalibration& rig) {
  const Eigen::Vector3d t = rig.T_right_left.translation();
  const double tolerance_m = kAlignedTolerance * rig.baseline_m();
  const double f_px = rig.left.fx_px;
  const auto same = [&](double px) { return std::abs(px - f_px) <= kAlignedTolerance * f_px; };
  return rig.left.distortion == Distortion::kNone && rig.right.distortion == Distortion::kNone &&
         rig.T_right_left.linear().isIdentity(kAlignedTolerance) && t.x() < 0 &&
         std::abs(t.y()) <= tolerance_m && std::abs(t.z()) <= tolerance_m && same(rig.left.fy_px) &&
         same(rig.right.fx_px) && same(rig.right.fy_px) && rig.left.cy_px == rig.right.cy_px;
}

/// Rows are the axes of the rectified frame in coordinates of the left camera.
Result<Eigen::Matrix3d> rectified_axes(const RigCalibration& rig) {
  const Eigen::Matrix3d R_left_right = rig.T_right_left.linear().transpose();
  const Eigen::Vector3d right_in_left = rig.T_right_left.inverse().translation();
  const Eigen::Vector3d x = right_in_left.normalized();
  const Eigen::Vector3d left_view = Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d right_view = R_left_right.col(2);
  if (left_view.dot(right_view) < kMinCosBetweenViews) {
    return fail("rig: the cameras look over 60 degrees apart");
  }
  const Eigen::Vector3d mean_view = (left_view + right_view).normalized();
  const Eigen::Vector3d across = mean_view.cross(x);
  if (across.norm() < kMinSinViewToBaseline)
    return fail("rig: the cameras look along the baseline");
  const Eigen::Vector3d y = across.normalized();
  Eigen::Matrix3d R_rectified_left;
  R_rectified_left << x.transpose(), y.transpose(), x.cross(y).transpose();
  return R_rectified_left;
}

cv::Matx33d to_matx(const Eigen::Matrix3d& M) {
  cv::Matx33d R;
  cv::eigen2cv(M, R);
  return R;
}

std::vector<cv::Point2d> undistort(const std::vector<cv::Point2d>& pixels, const CameraModel& model,
                                   const cv::Matx33d& R) {
  std::vector<cv::Point2d> rays;
  if (model.distortion == Distortion::kEquidistant) {
    cv::fisheye::undistortPoints(pixels, rays, model.K(), model.coefficients, R);
  } else {
    const cv::TermCriteria until{cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 100, 1e-10};
    cv::undistortPoints(pixels, rays, model.K(), model.coefficients, R, cv::noArray(), until);
  }
  return rays;
}

/// A rectangle on the plane z = 1.
struct Window {
  double left = -std::numeric_limits<double>::infinity();
  double right = std::numeric_limits<double>::infinity();
  double top = -std::numeric_limits<double>::infinity();
  double bottom = std::numeric_limits<double>::infinity();

  [[nodiscard]] double width() const { return right - left; }
  [[nodiscard]] double height() const { return bottom - top; }
};

/// Shrinks the window until no edge of the raw image, seen from the rectified camera, runs through
/// it. An edge bounds the side that its middle lies on.
void shrink_to_picture(Window& window, const CameraModel& model, const cv::Matx33d& R,
                       cv::Size raw_size) {
  const double w = raw_size.width - 1;
  const double h = raw_size.height - 1;
  const cv::Point2d corners[] = {{0, 0}, {w, 0}, {w, h}, {0, h}};
  const cv::Point2d centre = undistort({{w / 2, h / 2}}, model, R).front();
  for (int edge = 0; edge < 4; ++edge) {
    const cv::Point2d from = corners[edge];
    const cv::Point2d along = corners[(edge + 1) % 4] - from;
    std::vector<cv::Point2d> pixels;
    for (int i = 0; i <= kSamplesPerEdge; ++i) {
      pixels.push_back(from + along * (static_cast<double>(i) / kSamplesPerEdge));
    }
    const auto rays = undistort(pixels, model, R);
    const cv::Point2d middle = rays[kSamplesPerEdge / 2] - centre;
    const bool sideways = std::abs(middle.x) > std::abs(middle.y);
    for (const cv::Point2d& ray : rays) {
      if (sideways && middle.x < 0) window.left = std::max(window.left, ray.x);
      if (sideways && middle.x > 0) window.right = std::min(window.right, ray.x);
      if (!sideways && middle.y < 0) window.top = std::max(window.top, ray.y);
      if (!sideways && middle.y > 0) window.bottom = std::min(window.bottom, ray.y);
    }
  }
}

/// For each rectified pixel, where it lies in the raw image.
struct Sources {
  cv::Mat x_px;
  cv::Mat y_px;

  [[nodiscard]] bool all_within(cv::Size size) const {
    const cv::Mat within =
        (x_px >= 0) & (x_px <= size.width - 1) & (y_px >= 0) & (y_px <= size.height - 1);
    return cv::countNonZero(within) == static_cast<int>(within.total());
  }
};

Sources sources_of(const CameraModel& model, const cv::Matx33d& R, const cv::Matx33d& K,
                   cv::Size size) {
  Sources sources;
  if (model.distortion == Distortion::kEquidistant) {
    cv::fisheye::initUndistortRectifyMap(model.K(), model.coefficients, R, K, size, CV_32FC1,
                                         sources.x_px, sources.y_px);
  } else {
    cv::initUndistortRectifyMap(model.K(), model.coefficients, R, K, size, CV_32FC1, sources.x_px,
                                sources.y_px);
  }
  return sources;
}

}  // namespace

Result<Rectifier> Rectifier::create(const RigCalibration& rig) {
  if (auto ok = camera::check(rig); !ok) return tl::make_unexpected(ok.error());
  Rectifier rectifier;
  rectifier.raw_size_ = {rig.width_px, rig.height_px};
  rectifier.camera_.baseline_m = rig.baseline_m();
  if (rig.rectified && is_row_aligned(rig)) {
    rectifier.camera_.f_px = rig.left.fx_px;
    rectifier.camera_.cx_px = rig.left.cx_px;
    rectifier.camera_.cy_px = rig.left.cy_px;
    rectifier.camera_.doffs_px = rig.right.cx_px - rig.left.cx_px;
    rectifier.camera_.width_px = rig.width_px;
    rectifier.camera_.height_px = rig.height_px;
    rectifier.camera_.T_body_camera = rig.T_body_left;
    return rectifier;
  }
  const auto R_rectified_left = rectified_axes(rig);
  if (!R_rectified_left) return tl::make_unexpected(R_rectified_left.error());
  const cv::Matx33d R_left = to_matx(*R_rectified_left);
  const cv::Matx33d R_right = to_matx(*R_rectified_left * rig.T_right_left.linear().transpose());
  try {
    Window window;
    shrink_to_picture(window, rig.left, R_left, rectifier.raw_size_);
    shrink_to_picture(window, rig.right, R_right, rectifier.raw_size_);
    if (!(window.width() > kMinViewWidth) || !(window.height() > kMinViewWidth) ||
        !std::isfinite(window.width()) || !std::isfinite(window.height())) {
      return fail("rig: the cameras share no view");
    }
    const bool on_its_side =
        std::abs((*R_rectified_left)(0, 1)) > std::abs((*R_rectified_left)(0, 0));
    const cv::Size size = on_its_side ? cv::Size(rig.height_px, rig.width_px) : rectifier.raw_size_;
    double f_px = std::max((size.width - 1) / window.width(), (size.height - 1) / window.height());
    cv::Matx33d K;
    Sources left;
    Sources right;
    for (int step = 0;; ++step) {
      if (step == kMaxZoomSteps) return fail("rig: a lens model folds the image over itself");
      f_px *= kZoomStep;
      K = {f_px, 0,    (size.width - 1 - f_px * (window.left + window.right)) / 2,
           0,    f_px, (size.height - 1 - f_px * (window.top + window.bottom)) / 2,
           0,    0,    1};
      left = sources_of(rig.left, R_left, K, size);
      right = sources_of(rig.right, R_right, K, size);
      if (left.all_within(rectifier.raw_size_) && right.all_within(rectifier.raw_size_)) break;
    }
    cv::convertMaps(left.x_px, left.y_px, rectifier.left_.map, rectifier.left_.fractions, CV_16SC2);
    cv::convertMaps(right.x_px, right.y_px, rectifier.right_.map, rectifier.right_.fractions,
                    CV_16SC2);

    rectifier.camera_.f_px = f_px;
    rectifier.camera_.cx_px = K(0, 2);
    rectifier.camera_.cy_px = K(1, 2);
    rectifier.camera_.width_px = size.width;
    rectifier.camera_.height_px = size.height;
    rectifier.camera_.T_body_camera = rig.T_body_left;
    rectifier.camera_.T_body_camera.linear() =
        rig.T_body_left.linear() * R_rectified_left->transpose();
  } catch (const cv::Exception& exception) {
    return fail(std::string("rig: ") + exception.what());
  }
  return rectifier;
}

Result<RectifiedPair> Rectifier::rectify(const cv::Mat& left, const cv::Mat& right) const {
  if (left.type() != CV_8UC1 || right.type() != CV_8UC1 || left.empty() || right.empty()) {
    return fail("stereo pair: both images must be 8-bit grey and not empty");
  }
  if (left.size() != raw_size_ || right.size() != raw_size_) {
    return fail("stereo pair: an image is not of the rig's size, " +
                std::to_string(raw_size_.width) + "x" + std::to_string(raw_size_.height));
  }
  if (passes_through()) return RectifiedPair{left, right};
  try {
    RectifiedPair pair;
    cv::remap(left, pair.left, left_.map, left_.fractions, cv::INTER_LINEAR);
    cv::remap(right, pair.right, right_.map, right_.fractions, cv::INTER_LINEAR);
    return pair;
  } catch (const cv::Exception& exception) {
    return fail(std::string("stereo pair: ") + exception.what());
  }
}

}  // namespace cairn::stereo
