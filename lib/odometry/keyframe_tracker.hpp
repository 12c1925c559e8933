// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "core/geometry.hpp"
#include "odometry/belief.hpp"
#include "odometry/flow_tracker.hpp"
#include "odometry/stereo_odometry_config.hpp"
#include "odometry/stereo_pose.hpp"
#include "stereo/disparity_image.hpp"

namespace cairn::odometry {

/// A frame that is being looked at.
struct View {
  const cv::Mat& left;
  const cv::Mat& right;
  const stereo::RectifiedCamera& camera;
  Pyramid pyramid;
};

/// Where the body is by what a frame found of the keyframe.
struct Sighting {
  /// Its covariance is that of the way from the keyframe to here.
  Belief body;
  StereoPose pose;  ///< is_inlier is per pair that was followed
};

/// Holds a keyframe, corners with their disparity, and finds frames in relation to it.
class KeyframeTracker {
 public:
  explicit KeyframeTracker(const StereoOdometryConfig& config) : config_{config} {}

  [[nodiscard]] bool has_keyframe() const { return keyframe_.has_value(); }
  [[nodiscard]] int points() const {
    return keyframe_ ? static_cast<int>(keyframe_->points.size()) : 0;
  }
  void forget() { keyframe_.reset(); }
  /// Forgets a keyframe of another camera.
  void expect(const stereo::RectifiedCamera& camera);

  /// The keyframe's points that are found in both images, if the camera is about where it is
  /// expected.
  [[nodiscard]] std::vector<PointPair> follow(const View& view,
                                              const Isometry& T_odom_camera_expected) const;

  /// The pose that most pairs agree on; nothing if fewer than `min_inliers` do.
  [[nodiscard]] std::optional<Sighting> locate(const std::vector<PointPair>& pairs,
                                               const Isometry& T_odom_camera_expected,
                                               int min_inliers) const;

  /// The same by those pairs that `first` leaves unexplained.
  [[nodiscard]] std::optional<Sighting> locate_by_the_rest(const std::vector<PointPair>& pairs,
                                                           const Sighting& first,
                                                           const Isometry& T_odom_camera_expected,
                                                           int min_inliers) const;

  /// True if too little is left of the keyframe.
  [[nodiscard]] bool is_worn(const std::vector<PointPair>& pairs, const Sighting& sighting) const;

  /// Makes the view the keyframe: with points that agreed with `sighting`, their disparity averaged
  /// with what the old keyframe makes of it (weighted by variance), and fresh corners. Without a
  /// sighting an old keyframe stays if the view holds too few points to start from. True if the
  /// view is the keyframe now.
  bool renew(View& view, const Isometry& T_odom_body, const std::vector<PointPair>& pairs,
             const std::optional<Sighting>& sighting);

 private:
  struct KeyPoint {
    StereoPixel pixel;
    double disparity_sigma_px = 0;
  };
  struct Keyframe {
    Pyramid pyramid;
    std::vector<KeyPoint> points;
    Isometry T_odom_camera = Isometry::Identity();
    stereo::RectifiedCamera camera;
  };

  [[nodiscard]] std::vector<KeyPoint> carried_over(const std::vector<PointPair>& pairs,
                                                   const StereoPose& pose) const;
  [[nodiscard]] Keyframe make_keyframe(View& view, const Isometry& T_odom_camera,
                                       std::vector<KeyPoint> points) const;

  StereoOdometryConfig config_;
  std::optional<Keyframe> keyframe_;
};

}  // namespace cairn::odometry
