// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "core/config.hpp"
#include "core/geometry.hpp"
#include "core/result.hpp"
#include "core/time.hpp"
#include "odometry/checkpoint.hpp"
#include "odometry/flow_tracker.hpp"
#include "odometry/motion.hpp"
#include "odometry/stereo_pose.hpp"
#include "stereo/disparity_image.hpp"

namespace cairn::odometry {

struct StereoOdometryConfig {
  int points = 250;
  int min_point_distance_px = 10;
  double max_disparity_px = 192;
  int min_inliers = 12;
  double keyframe_share = 0.6;
  double keyframe_flow_share = 0.1;
  double max_speed_mps = 30;
  double max_turn_radps = 6;
  double coast_s = 0.5;
  double coast_accel_mps2 = 1.0;
  double coast_turn_accel_radps2 = 3.0;
  int seed = 1;

  void visit(ConfigVisitor& v) {
    v.integer("points", points, 30, 2000, "", "how many points to follow");
    v.integer("min_point_distance_px", min_point_distance_px, 3, 100, "px",
              "how far apart the points lie at least");
    v.number("max_disparity_px", max_disparity_px, {16, 1024}, "px",
             "largest disparity searched for a new point");
    v.integer("min_inliers", min_inliers, 6, 200, "", "fewer agreeing points give no pose");
    v.number("keyframe_share", keyframe_share, {0.1, 0.95}, "",
             "a new keyframe when less than this share of the keyframe's points agree");
    v.number("keyframe_flow_share", keyframe_flow_share, {0.005, 0.5}, "",
             "a new keyframe when the points have moved by this share of the image's width");
    v.number("max_speed_mps", max_speed_mps, {0.1, 100}, "m/s", "a faster pose is not believed");
    v.number("max_turn_radps", max_turn_radps, {0.1, 50}, "rad/s", "a faster turn is not believed");
    v.number("coast_s", coast_s, {0, 10}, "s",
             "without points: time for which the last velocity is kept; then it is zero");
    v.number("coast_accel_mps2", coast_accel_mps2, {0, 50}, "m/s^2",
             "without points: acceleration to reckon with (one sigma)");
    v.number("coast_turn_accel_radps2", coast_turn_accel_radps2, {0, 100}, "rad/s^2",
             "without points: angular acceleration to reckon with (one sigma)");
    v.integer("seed", seed, 0, 1 << 30, "", "of the random triples that wrong points are found by");
  }
};

/// Where the body is, by one frame.
struct OdometryEstimate {
  Utime utime = 0;
  Isometry T_odom_body = Isometry::Identity();
  Twist twist = Twist::Zero();  ///< mean since the last pose not coasted; body frame
  /// Of the motion since the frame before: in the body frame, order as in Twist [m^2, rad^2].
  Matrix6d step_covariance = Matrix6d::Zero();
  /// 0 (nothing seen) to 1 (50 points or more agree, and at least 70 % of those followed).
  double quality = 0;
  int tracked = 0;          ///< points followed into this frame and found in the right image
  int inliers = 0;          ///< of those, points that agree with the pose
  std::uint32_t epoch = 0;  ///< rises where the chain of measured motion is broken by a restart
  bool coasting = false;    ///< the pose was not measured but extrapolated
  bool is_keyframe = false;
};

/// Follows a stereo camera by sparse points, frame to keyframe.
///
/// The odometry frame is the body's at the first frame. A keyframe holds corners with their
/// disparity; each new frame finds them again by optical flow, measures their disparity anew, and
/// gets its pose from that. When too few are left, the frame becomes a keyframe: the points that
/// agreed are carried over, their disparity averaged with what the old keyframe makes of it
/// (weighted by variance), and fresh corners join.
///
/// Where no pose can be measured, the velocity is kept for coast_s, the covariance says how far
/// that may be off, quality is 0 and `coasting` is set. The keyframe stays while the images hold
/// too few points to start from, so that a blurred or dark spell that ends in view of it leaves no
/// error behind. Results depend on the images, their times and the config alone.
class StereoOdometry {
 public:
  explicit StereoOdometry(const StereoOdometryConfig& config) : config_{config} {}

  /// Both images CV_8UC1, rectified, of the camera's size. An error says what is wrong with the
  /// images or the camera, or that utime does not rise; the state is then as before. A utime over 1
  /// s back begins a new epoch: the pose is kept, the velocity is not.
  [[nodiscard]] Result<OdometryEstimate> update(const cv::Mat& left, const cv::Mat& right,
                                                const stereo::RectifiedCamera& camera, Utime utime);

  /// What resume() needs, as of the last frame.
  [[nodiscard]] Checkpoint checkpoint() const;

  /// Goes on after a restart, instead of at the identity: the next frame is placed by the
  /// checkpoint's velocity (for coast_s at most), with a covariance to match, in the next epoch.
  void resume(const Checkpoint& checkpoint);

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
  struct View;
  struct Measured;

  [[nodiscard]] Isometry predicted_body(double dt_s) const;
  [[nodiscard]] std::optional<Measured> measure(const View& view, const Isometry& T_odom_camera,
                                                Utime utime, OdometryEstimate& estimate) const;
  [[nodiscard]] bool believable(const Twist& twist) const;
  [[nodiscard]] bool wants_keyframe(const Measured& measured) const;
  [[nodiscard]] std::vector<KeyPoint> carried_over(const Measured& measured) const;
  [[nodiscard]] Keyframe make_keyframe(View& view, const Isometry& T_odom_camera,
                                       std::vector<KeyPoint> points) const;
  void coast(double dt_s, OdometryEstimate& estimate) const;
  [[nodiscard]] double quality(int tracked, int inliers) const;

  StereoOdometryConfig config_;
  std::optional<Keyframe> keyframe_;
  bool started_ = false;
  bool resumed_ = false;
  Utime utime_ = 0;
  std::uint32_t epoch_ = 0;
  Isometry T_odom_body_ = Isometry::Identity();
  Twist twist_ = Twist::Zero();
  double coasted_s_ = 0;
  Isometry T_odom_vouched_ =
      Isometry::Identity();  ///< the last pose measured, or set by a keyframe
  Utime vouched_utime_ = 0;
};

}  // namespace cairn::odometry
