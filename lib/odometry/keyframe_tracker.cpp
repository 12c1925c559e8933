// SPDX-License-Identifier: Apache-2.0
#include "odometry/keyframe_tracker.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "odometry/corner_grid.hpp"
#include "odometry/row_matcher.hpp"

namespace cairn::odometry {
namespace {

using stereo::RectifiedCamera;

constexpr int kMargin_px = 10;
constexpr double kMinDisparity_px = 0.5;
constexpr double kDisparitySigma_px = 0.2;
constexpr double kMinCarriedSigma_px = 0.1;
constexpr double kReach_px = 3;
constexpr double kReachShare = 0.2;

const PixelNoise kNoise{0.3, kDisparitySigma_px};

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

void KeyframeTracker::expect(const RectifiedCamera& camera) {
  if (keyframe_ && !same_camera(keyframe_->camera, camera)) keyframe_.reset();
}

std::vector<PointPair> KeyframeTracker::follow(const View& view,
                                               const Isometry& T_odom_camera_expected) const {
  std::vector<PointPair> pairs;
  if (!keyframe_ || keyframe_->points.empty()) return pairs;
  const RectifiedCamera& camera = view.camera;
  const Isometry guess = T_odom_camera_expected.inverse() * keyframe_->T_odom_camera;

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
    pairs.push_back({in_view[i].pixel, in_view[i].disparity_sigma_px, {u_px, v_px, disparity_px}});
  }
  return pairs;
}

std::optional<Sighting> KeyframeTracker::locate(const std::vector<PointPair>& pairs,
                                                const Isometry& T_odom_camera_expected,
                                                int min_inliers) const {
  if (!keyframe_) return std::nullopt;
  const RectifiedCamera& camera = keyframe_->camera;
  const Isometry guess = T_odom_camera_expected.inverse() * keyframe_->T_odom_camera;
  auto pose = solve_stereo_pose(pairs, camera, kNoise, guess, min_inliers,
                                static_cast<std::uint32_t>(config_.seed));
  if (!pose) return std::nullopt;
  Sighting sighting;
  sighting.body.T_odom_body = rigid(keyframe_->T_odom_camera * pose->T_new_anchor.inverse() *
                                    camera.T_body_camera.inverse());
  sighting.body.covariance = covariance_in(camera.T_body_camera, pose->covariance);
  sighting.pose = std::move(*pose);
  return sighting;
}

std::optional<Sighting> KeyframeTracker::locate_by_the_rest(const std::vector<PointPair>& pairs,
                                                            const Sighting& first,
                                                            const Isometry& T_odom_camera_expected,
                                                            int min_inliers) const {
  std::vector<PointPair> rest;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    if (!first.pose.is_inlier[i]) rest.push_back(pairs[i]);
  }
  auto sighting = locate(rest, T_odom_camera_expected, min_inliers);
  if (!sighting) return std::nullopt;
  std::vector<bool> is_inlier(pairs.size(), false);
  for (std::size_t i = 0, at = 0; i < pairs.size(); ++i) {
    if (!first.pose.is_inlier[i]) is_inlier[i] = sighting->pose.is_inlier[at++];
  }
  sighting->pose.is_inlier = std::move(is_inlier);
  return sighting;
}

bool KeyframeTracker::is_worn(const std::vector<PointPair>& pairs, const Sighting& sighting) const {
  if (sighting.pose.inliers < config_.keyframe_share * points()) return true;
  std::vector<double> flow_px;
  flow_px.reserve(pairs.size());
  for (const PointPair& pair : pairs) {
    flow_px.push_back(
        std::hypot(pair.seen.u_px - pair.anchor.u_px, pair.seen.v_px - pair.anchor.v_px));
  }
  return median(std::move(flow_px)) > config_.keyframe_flow_share * keyframe_->camera.width_px;
}

bool KeyframeTracker::renew(View& view, const Isometry& T_odom_body,
                            const std::vector<PointPair>& pairs,
                            const std::optional<Sighting>& sighting) {
  Keyframe fresh =
      make_keyframe(view, T_odom_body * view.camera.T_body_camera,
                    sighting ? carried_over(pairs, sighting->pose) : std::vector<KeyPoint>{});
  const bool rich = static_cast<int>(fresh.points.size()) >= 2 * config_.min_inliers;
  if (!sighting && !rich && keyframe_) return false;
  keyframe_ = std::move(fresh);
  return true;
}

std::vector<KeyframeTracker::KeyPoint> KeyframeTracker::carried_over(
    const std::vector<PointPair>& pairs, const StereoPose& pose) const {
  const double seen_variance = kDisparitySigma_px * kDisparitySigma_px;
  std::vector<KeyPoint> points;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    if (!pose.is_inlier[i]) continue;
    const PointPair& pair = pairs[i];
    const Eigen::Vector3d p = pose.T_new_anchor * to_point(pair.anchor, keyframe_->camera);
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

KeyframeTracker::Keyframe KeyframeTracker::make_keyframe(View& view, const Isometry& T_odom_camera,
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

}  // namespace cairn::odometry
