// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "core/geometry.hpp"
#include "core/result.hpp"
#include "core/time.hpp"
#include "odometry/checkpoint.hpp"
#include "odometry/keyframe_tracker.hpp"
#include "odometry/motion.hpp"
#include "odometry/stereo_odometry_config.hpp"
#include "odometry/track_kinematics.hpp"
#include "odometry/track_prior.hpp"
#include "stereo/disparity_image.hpp"

namespace cairn::odometry {

/// What a pose rests on.
enum class Basis {
  kNothing,  ///< extrapolated
  kSight,
  kTracks,
  kBoth,
};

/// Who was believed where sight and tracks contradicted each other.
enum class Dispute {
  kNone,
  kTracksOverruled,  ///< most points agree on it: the tracks slip, or something moves the robot
  kSightOverruled,   ///< too few points agree on anything
  kMoverLeftOut,     ///< the points that most agreed on were on something that moves
};

/// Where the body is, by one frame.
struct OdometryEstimate {
  Utime utime = 0;
  Isometry T_odom_body = Isometry::Identity();
  Twist twist = Twist::Zero();  ///< mean since the last pose not coasted; body frame
  /// Of the motion since the frame before: in the body frame, order as in Twist [m^2, rad^2].
  Matrix6d step_covariance = Matrix6d::Zero();
  /// 0 (extrapolated), 0.2 (tracks alone) to 1 (50 points or more agree, and at least 70 % of those
  /// followed).
  double quality = 0;
  int tracked = 0;          ///< points followed into this frame and found in the right image
  int inliers = 0;          ///< of those, points that agree with the pose
  std::uint32_t epoch = 0;  ///< rises where the chain of measured motion is broken by a restart
  Basis basis = Basis::kNothing;
  Dispute dispute = Dispute::kNone;
  bool coasting = false;  ///< the pose was not measured but extrapolated
};

/// Follows a body by a stereo camera on it, frame to keyframe, and by its tracks.
///
/// The odometry frame is the body's at the first frame. A keyframe holds corners with their
/// disparity; each new frame finds them again by optical flow, measures their disparity anew, and
/// gets its pose from that. When too few are left, the frame becomes a keyframe: the points that
/// agreed are carried over, and fresh corners join.
///
/// Where the tracks are heard they say where to look for the points, and both poses are weighted by
/// their information (TrackPrior). Where the two contradict each other the points decide. Those
/// that the pose of most points leaves unexplained are asked again: if half of min_inliers agree on
/// a pose that the tracks agree with, most points were on something that moves, and the second pose
/// is taken. Else sight is believed if twice min_inliers, and half of the points followed, agree
/// (the tracks slip; somebody pushes the robot). Else, and for a second after something that moves
/// was about, the tracks are.
///
/// Where no pose is seen, the tracks alone carry on, with the covariance of their slip. Without
/// them the velocity is kept for coast_s, the covariance says how far that may be off, quality is 0
/// and `coasting` is set. The keyframe stays while the images hold too few points to start from, so
/// that a blurred or dark spell that ends in view of it leaves no error behind. Results depend on
/// the images, the tracks, their times and the config alone; without tracks they are those of sight
/// alone.
class StereoOdometry {
 public:
  explicit StereoOdometry(const StereoOdometryConfig& config, const TrackModel& tracks = {})
      : config_{config}, track_model_{tracks}, tracker_{config} {}

  using Tracks = std::optional<TrackHistory::Moment>;

  /// Both images CV_8UC1, rectified, of the camera's size; where the tracks were at `utime`, if
  /// they say. An error says what is wrong with the images or the camera, or that utime does not
  /// rise; the state is then as before. A utime over 1 s back begins a new epoch: the pose is kept,
  /// the velocity is not.
  [[nodiscard]] Result<OdometryEstimate> update(const cv::Mat& left, const cv::Mat& right,
                                                const stereo::RectifiedCamera& camera, Utime utime,
                                                const Tracks& tracks = {});

  /// Does what the last frame left to be done before the next one: makes it the keyframe, where one
  /// is due. update() does it otherwise; whoever does it after publishing has answered sooner.
  [[nodiscard]] Result<void> settle();

  /// The same as update() without looking.
  [[nodiscard]] Result<OdometryEstimate> update_blind(Utime utime, const Tracks& tracks);

  /// What resume() needs, as of the last frame.
  [[nodiscard]] Checkpoint checkpoint() const;

  /// Goes on after a restart, instead of at the identity, in the next epoch. `tracks`: where they
  /// were at the checkpoint's utime, by a history that began with the checkpoint's reading; the
  /// motion since then is theirs. Without them the next frame is placed by the checkpoint's
  /// velocity (for coast_s at most), with a covariance to match.
  void resume(const Checkpoint& checkpoint, const Tracks& tracks = {});

 private:
  /// The last frame that tracks could say something of.
  struct Anchor {
    Utime utime = 0;
    TrackHistory::Moment moment;
    Belief body;  ///< its covariance is that of the way from the keyframe
    bool seen = false;
  };
  struct Frame;
  /// A frame that is to become the keyframe.
  struct Unsettled {
    cv::Mat left;
    cv::Mat right;
    stereo::RectifiedCamera camera;
    Pyramid pyramid;
    std::vector<PointPair> pairs;
    std::optional<Sighting> sighting;
  };

  [[nodiscard]] Result<void> check_time(Utime utime) const;
  [[nodiscard]] Frame begin(Utime utime, const Tracks& tracks);
  void look(View& view, Frame& frame);
  [[nodiscard]] Result<OdometryEstimate> first_look(OdometryEstimate estimate);
  void vouch(Utime utime, const Isometry& T_odom_body);
  [[nodiscard]] std::optional<Sighting> see(const View& view, Frame& frame) const;
  [[nodiscard]] std::optional<Sighting> judge(std::optional<Sighting> sighting,
                                              const Isometry& T_odom_camera_expected,
                                              Frame& frame) const;
  void take_seen(const Sighting& sighting, Frame& frame) const;
  void take_unseen(Frame& frame) const;
  void take_by_tracks(Frame& frame) const;
  void coast(Frame& frame) const;
  void finish(const Tracks& tracks, const Frame& frame);

  [[nodiscard]] Isometry predicted_body(double dt_s) const;
  [[nodiscard]] Matrix6d coasting_covariance(double dt_s) const;
  [[nodiscard]] Twist twist_since_vouched(const Isometry& T_odom_body, Utime utime) const;
  [[nodiscard]] bool believable(const Twist& twist) const;
  [[nodiscard]] double quality(int tracked, int inliers) const;

  StereoOdometryConfig config_;
  TrackModel track_model_;
  KeyframeTracker tracker_;
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
  std::optional<Anchor> anchor_;
  std::optional<Unsettled> unsettled_;
  bool tracks_trusted_ = true;        ///< they were not overruled when they were last heard
  std::optional<Utime> mover_utime_;  ///< when one was last left out
};

}  // namespace cairn::odometry
