// SPDX-License-Identifier: Apache-2.0
#include "odometry/stereo_odometry.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "odometry/corner_grid.hpp"
#include "odometry/row_matcher.hpp"

namespace cairn::odometry {
namespace {

using stereo::RectifiedCamera;

constexpr int kMinSide_px = 64;
constexpr int kMargin_px = 10;
constexpr double kMinDisparity_px = 0.5;
constexpr double kDisparitySigma_px = 0.2;
constexpr double kMinCarriedSigma_px = 0.1;
constexpr double kReach_px = 3;
constexpr double kReachShare = 0.2;
constexpr double kGoodInliers = 50;
constexpr double kGoodShare = 0.7;
constexpr double kFirstPoseSigma = 1e-6;
constexpr std::int64_t kTimeJump_us = kMicrosecondsPerSecond;

const PixelNoise kNoise{0.3, kDisparitySigma_px};

Result<void> check_input(const cv::Mat& left, const cv::Mat& right, const RectifiedCamera& camera) {
  if (left.type() != CV_8UC1 || right.type() != CV_8UC1 || left.empty() || right.empty()) {
    return fail("odometry: both images must be 8-bit grey and not empty");
  }
  if (left.size() != right.size()) return fail("odometry: left and right differ in size");
  if (left.cols != camera.width_px || left.rows != camera.height_px) {
    return fail("odometry: " + std::to_string(left.cols) + "x" + std::to_string(left.rows) +
                " px, but the camera has " + std::to_string(camera.width_px) + "x" +
                std::to_string(camera.height_px));
  }
  if (left.cols < kMinSide_px || left.rows < kMinSide_px) {
    return fail("odometry: smaller than " + std::to_string(kMinSide_px) + " px");
  }
  const double numbers[] = {camera.f_px, camera.cx_px, camera.cy_px, camera.doffs_px,
                            camera.baseline_m};
  if (!std::all_of(std::begin(numbers), std::end(numbers),
                   [](double x) { return std::isfinite(x); }) ||
      !camera.T_body_camera.matrix().allFinite() || !(camera.f_px > 0) ||
      !(camera.baseline_m > 0)) {
    return fail("odometry: the camera's numbers belong to no stereo camera");
  }
  return {};
}

bool same_camera(const RectifiedCamera& a, const RectifiedCamera& b) {
  return a.f_px == b.f_px && a.cx_px == b.cx_px && a.cy_px == b.cy_px && a.doffs_px == b.doffs_px &&
         a.baseline_m == b.baseline_m && a.width_px == b.width_px && a.height_px == b.height_px &&
         a.T_body_camera.matrix() == b.T_body_camera.matrix();
}

cv::Point2f to_cv(const StereoPixel& pixel) {
  return {static_cast<float>(pixel.u_px), static_cast<float>(pixel.v_px)};
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

struct StereoOdometry::View {
  const cv::Mat& left;
  const cv::Mat& right;
  const RectifiedCamera& camera;
  Pyramid pyramid;
};

/// What a frame found of its keyframe.
struct StereoOdometry::Measured {
  std::vector<PointPair> pairs;
  StereoPose pose;
};

Result<OdometryEstimate> StereoOdometry::update(const cv::Mat& left, const cv::Mat& right,
                                                const RectifiedCamera& camera, Utime utime) {
  if (auto ok = check_input(left, right, camera); !ok) return tl::make_unexpected(ok.error());
  bool broken = resumed_;
  if (started_ && utime <= utime_) {
    if (utime_ - utime <= kTimeJump_us && !resumed_) {
      return fail("odometry: utime " + std::to_string(utime) + " does not rise above " +
                  std::to_string(utime_));
    }
    broken = true;
  }
  try {
    const double dt_s = started_ && utime > utime_ ? to_seconds(utime - utime_) : 0;
    if (broken) {
      keyframe_.reset();
      ++epoch_;
      if (dt_s == 0) twist_.setZero();
    }
    if (keyframe_ && !same_camera(keyframe_->camera, camera)) keyframe_.reset();

    View view{left, right, camera, make_pyramid(left)};
    OdometryEstimate estimate;
    estimate.utime = utime;
    estimate.epoch = epoch_;
    const Isometry predicted = predicted_body(dt_s);
    const auto measured = measure(view, predicted * camera.T_body_camera, utime, estimate);
    if (measured) {
      coasted_s_ = 0;
    } else if (started_) {
      estimate.T_odom_body = predicted;
      coast(dt_s, estimate);
      coasted_s_ += dt_s;
    } else {
      estimate.step_covariance = Matrix6d::Identity() * kFirstPoseSigma * kFirstPoseSigma;
    }
    if (!measured || wants_keyframe(*measured)) {
      Keyframe fresh = make_keyframe(view, estimate.T_odom_body * camera.T_body_camera,
                                     measured ? carried_over(*measured) : std::vector<KeyPoint>{});
      // A blurred or dark frame does not replace a keyframe that the next frame may find again.
      const bool rich = static_cast<int>(fresh.points.size()) >= 2 * config_.min_inliers;
      estimate.is_keyframe = measured || rich || !keyframe_;
      if (estimate.is_keyframe) keyframe_ = std::move(fresh);
    }
    if (measured || estimate.is_keyframe) {
      T_odom_vouched_ = estimate.T_odom_body;
      vouched_utime_ = utime;
    }
    if (!started_) {
      estimate.tracked = estimate.inliers = static_cast<int>(keyframe_->points.size());
      estimate.quality = quality(estimate.tracked, estimate.inliers);
    }
    if (!estimate.coasting) twist_ = estimate.twist;
    T_odom_body_ = estimate.T_odom_body;
    utime_ = utime;
    started_ = true;
    resumed_ = false;
    return estimate;
  } catch (const cv::Exception& exception) {
    return fail(std::string("odometry: ") + exception.what());
  }
}

Isometry StereoOdometry::predicted_body(double dt_s) const {
  const double moving_s = std::clamp(config_.coast_s - coasted_s_, 0.0, dt_s);
  return T_odom_body_ * motion_of(twist_, moving_s);
}

std::optional<StereoOdometry::Measured> StereoOdometry::measure(const View& view,
                                                                const Isometry& T_odom_camera,
                                                                Utime utime,
                                                                OdometryEstimate& estimate) const {
  if (!keyframe_ || keyframe_->points.empty()) return std::nullopt;
  const RectifiedCamera& camera = view.camera;
  const Isometry guess = T_odom_camera.inverse() * keyframe_->T_odom_camera;

  std::vector<KeyPoint> in_view;
  std::vector<cv::Point2f> from_px;
  std::vector<cv::Point2f> expected_px;
  std::vector<double> expected_disparity_px;
  for (const KeyPoint& point : keyframe_->points) {
    const Eigen::Vector3d p = guess * to_point(point.pixel, camera);
    if (p.z() <= 0) continue;
    const StereoPixel expected = to_pixel(p, camera);
    if (!cv::Rect2d(0, 0, camera.width_px, camera.height_px)
             .contains({expected.u_px, expected.v_px})) {
      continue;
    }
    in_view.push_back(point);
    from_px.push_back(to_cv(point.pixel));
    expected_px.push_back(to_cv(expected));
    expected_disparity_px.push_back(expected.disparity_px);
  }
  const auto found = track(keyframe_->pyramid, view.pyramid, from_px, expected_px);

  Measured measured;
  const RowMatcher rows(view.left, view.right);
  for (std::size_t i = 0; i < found.size(); ++i) {
    if (!found[i].found) continue;
    const auto u_px = static_cast<double>(found[i].at_px.x);
    const auto v_px = static_cast<double>(found[i].at_px.y);
    const double about_px = expected_disparity_px[i] - camera.doffs_px;
    const double reach_px = kReach_px + kReachShare * expected_disparity_px[i];
    const auto match = rows.match(u_px, v_px, about_px - reach_px, about_px + reach_px);
    if (!match) continue;
    const double disparity_px = match->disparity_px + camera.doffs_px;
    if (disparity_px < kMinDisparity_px) continue;
    measured.pairs.push_back(
        {in_view[i].pixel, in_view[i].disparity_sigma_px, {u_px, v_px, disparity_px}});
  }
  estimate.tracked = static_cast<int>(measured.pairs.size());
  auto pose = solve_stereo_pose(measured.pairs, camera, kNoise, guess, config_.min_inliers,
                                static_cast<std::uint32_t>(config_.seed));
  if (!pose) return std::nullopt;
  measured.pose = std::move(*pose);
  const Isometry T_odom_body =
      rigid(keyframe_->T_odom_camera * measured.pose.T_new_anchor.inverse() *
            camera.T_body_camera.inverse());
  estimate.inliers = measured.pose.inliers;
  const Twist twist =
      twist_of(T_odom_vouched_.inverse() * T_odom_body, to_seconds(utime - vouched_utime_));
  if (!believable(twist)) return std::nullopt;
  estimate.T_odom_body = T_odom_body;
  estimate.twist = twist;
  estimate.step_covariance = covariance_in(camera.T_body_camera, measured.pose.covariance);
  estimate.quality = quality(estimate.tracked, estimate.inliers);
  return measured;
}

bool StereoOdometry::believable(const Twist& twist) const {
  return twist.allFinite() && twist.head<3>().norm() <= config_.max_speed_mps &&
         twist.tail<3>().norm() <= config_.max_turn_radps;
}

bool StereoOdometry::wants_keyframe(const Measured& measured) const {
  const auto points = static_cast<double>(keyframe_->points.size());
  if (measured.pose.inliers < config_.keyframe_share * points) return true;
  std::vector<double> flow_px;
  for (const PointPair& pair : measured.pairs) {
    flow_px.push_back(
        std::hypot(pair.seen.u_px - pair.anchor.u_px, pair.seen.v_px - pair.anchor.v_px));
  }
  return median(std::move(flow_px)) > config_.keyframe_flow_share * keyframe_->camera.width_px;
}

std::vector<StereoOdometry::KeyPoint> StereoOdometry::carried_over(const Measured& measured) const {
  const double seen_variance = kDisparitySigma_px * kDisparitySigma_px;
  std::vector<KeyPoint> points;
  for (std::size_t i = 0; i < measured.pairs.size(); ++i) {
    if (!measured.pose.is_inlier[i]) continue;
    const PointPair& pair = measured.pairs[i];
    const Eigen::Vector3d p = measured.pose.T_new_anchor * to_point(pair.anchor, keyframe_->camera);
    const double expected_px = to_pixel(p, keyframe_->camera).disparity_px;
    const double growth = expected_px / pair.anchor.disparity_px;
    const double expected_sigma_px = pair.anchor_sigma_px * growth * growth;
    const double expected_variance = expected_sigma_px * expected_sigma_px;
    const double share = seen_variance / (seen_variance + expected_variance);
    KeyPoint point{pair.seen, std::sqrt(share * expected_variance)};
    point.pixel.disparity_px += share * (expected_px - pair.seen.disparity_px);
    point.disparity_sigma_px = std::max(point.disparity_sigma_px, kMinCarriedSigma_px);
    points.push_back(point);
  }
  return points;
}

StereoOdometry::Keyframe StereoOdometry::make_keyframe(View& view, const Isometry& T_odom_camera,
                                                       std::vector<KeyPoint> points) const {
  std::vector<cv::Point2f> taken;
  taken.reserve(points.size());
  for (const KeyPoint& point : points) taken.push_back(to_cv(point.pixel));
  const RowMatcher rows(view.left, view.right);
  for (const cv::Point2f& corner : spread_corners(view.left, taken, config_.points,
                                                  config_.min_point_distance_px, kMargin_px)) {
    const auto u_px = static_cast<double>(corner.x);
    const auto v_px = static_cast<double>(corner.y);
    const auto match =
        rows.match_both_ways(u_px, v_px, -view.camera.doffs_px, config_.max_disparity_px);
    if (!match) continue;
    const double disparity_px = match->disparity_px + view.camera.doffs_px;
    if (disparity_px < kMinDisparity_px) continue;
    points.push_back({{u_px, v_px, disparity_px}, kDisparitySigma_px});
  }
  return {std::move(view.pyramid), std::move(points), T_odom_camera, view.camera};
}

void StereoOdometry::coast(double dt_s, OdometryEstimate& estimate) const {
  const double moving_s = std::clamp(config_.coast_s - coasted_s_, 0.0, dt_s);
  const double share = dt_s > 0 ? moving_s / dt_s : 0;
  estimate.coasting = true;
  estimate.quality = 0;
  estimate.twist = share * twist_;
  // The body may have gone on as it did, or stopped, or sped up.
  const double way_m = twist_.head<3>().norm() * dt_s + config_.coast_accel_mps2 * dt_s * dt_s / 2;
  const double turn_rad =
      twist_.tail<3>().norm() * dt_s + config_.coast_turn_accel_radps2 * dt_s * dt_s / 2;
  Vector6d variance;
  variance << Eigen::Vector3d::Constant(way_m * way_m),
      Eigen::Vector3d::Constant(turn_rad * turn_rad);
  variance.array() += kFirstPoseSigma * kFirstPoseSigma;
  estimate.step_covariance = variance.asDiagonal();
}

double StereoOdometry::quality(int tracked, int inliers) const {
  if (tracked == 0) return 0;
  const double share = static_cast<double>(inliers) / tracked;
  return std::min(1.0, inliers / kGoodInliers) * std::min(1.0, share / kGoodShare);
}

Checkpoint StereoOdometry::checkpoint() const { return {utime_, epoch_, T_odom_body_, twist_}; }

void StereoOdometry::resume(const Checkpoint& checkpoint) {
  keyframe_.reset();
  started_ = true;
  resumed_ = true;
  utime_ = checkpoint.utime;
  epoch_ = checkpoint.epoch;
  T_odom_body_ = rigid(checkpoint.T_odom_body);
  twist_ = checkpoint.twist;
  coasted_s_ = 0;
}

}  // namespace cairn::odometry
