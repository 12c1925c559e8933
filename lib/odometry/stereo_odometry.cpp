// SPDX-License-Identifier: Apache-2.0
#include "odometry/stereo_odometry.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

namespace cairn::odometry {
namespace {

using stereo::RectifiedCamera;

constexpr int kMinSide_px = 64;
constexpr double kGoodInliers = 50;
constexpr double kGoodShare = 0.7;
constexpr double kTracksQuality = 0.2;
constexpr double kFirstPoseSigma = 1e-6;
constexpr std::int64_t kTimeJump_us = kMicrosecondsPerSecond;
/// Against the tracks' word.
constexpr double kStrongShare = 0.5;
constexpr int kStrongInliers = 2;  // times min_inliers
constexpr std::int64_t kMoverRemembered_us = kMicrosecondsPerSecond;

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

}  // namespace

/// A frame on its way through update().
struct StereoOdometry::Frame {
  OdometryEstimate estimate;
  double dt_s = 0;
  Isometry T_odom_body_predicted = Isometry::Identity();
  std::optional<TrackStep> step;    ///< since the anchor
  std::optional<TrackPrior> prior;  ///< from there
  std::vector<PointPair> pairs;
  std::optional<Belief> agreed;            ///< of sight and tracks
  Matrix6d covariance = Matrix6d::Zero();  ///< of the way from the keyframe
};

Result<OdometryEstimate> StereoOdometry::update(const cv::Mat& left, const cv::Mat& right,
                                                const RectifiedCamera& camera, Utime utime,
                                                const Tracks& tracks) {
  if (auto ok = check_input(left, right, camera); !ok) return tl::make_unexpected(ok.error());
  if (auto ok = check_time(utime); !ok) return tl::make_unexpected(ok.error());
  if (auto settled = settle(); !settled) return tl::make_unexpected(settled.error());
  try {
    Frame frame = begin(utime, tracks);
    tracker_.expect(camera);
    View view{left, right, camera, make_pyramid(left)};
    look(view, frame);
    const bool first = !started_;
    finish(tracks, frame);
    return first ? first_look(frame.estimate) : frame.estimate;
  } catch (const cv::Exception& exception) {
    return fail(std::string("odometry: ") + exception.what());
  }
}

Result<OdometryEstimate> StereoOdometry::first_look(OdometryEstimate estimate) {
  if (auto settled = settle(); !settled) return tl::make_unexpected(settled.error());
  estimate.tracked = estimate.inliers = tracker_.points();
  estimate.quality = quality(estimate.tracked, estimate.inliers);
  return estimate;
}

Result<OdometryEstimate> StereoOdometry::update_blind(Utime utime, const Tracks& tracks) {
  if (auto ok = check_time(utime); !ok) return tl::make_unexpected(ok.error());
  Frame frame = begin(utime, tracks);
  take_unseen(frame);
  finish(tracks, frame);
  return frame.estimate;
}

Result<void> StereoOdometry::check_time(Utime utime) const {
  if (!started_ || resumed_ || utime > utime_ || utime_ - utime > kTimeJump_us) return {};
  return fail("odometry: utime " + std::to_string(utime) + " does not rise above " +
              std::to_string(utime_));
}

StereoOdometry::Frame StereoOdometry::begin(Utime utime, const Tracks& tracks) {
  Frame frame;
  const bool back = started_ && utime <= utime_;
  frame.dt_s = started_ && !back ? to_seconds(utime - utime_) : 0;
  if (resumed_ || back) {
    tracker_.forget();
    ++epoch_;
  }
  if (back) {
    twist_.setZero();
    anchor_.reset();
    mover_utime_.reset();
  }
  frame.estimate.utime = utime;
  frame.estimate.epoch = epoch_;
  frame.T_odom_body_predicted = predicted_body(frame.dt_s);
  if (!anchor_ || !tracks) return frame;
  frame.step = track_step(anchor_->moment, anchor_->utime, *tracks, utime, track_model_);
  if (!frame.step) return frame;
  frame.prior.emplace(anchor_->body, *frame.step, track_model_);
  if (tracks_trusted_) frame.T_odom_body_predicted = frame.prior->alone().T_odom_body;
  return frame;
}

void StereoOdometry::look(View& view, Frame& frame) {
  OdometryEstimate& estimate = frame.estimate;
  auto sighting = see(view, frame);
  if (sighting) {
    take_seen(*sighting, frame);
  } else {
    take_unseen(frame);
  }
  // A keyframe that sight was overruled by still says where the body was, once the view is free.
  const bool keeps = estimate.dispute == Dispute::kSightOverruled &&
                     estimate.tracked >= kStrongInliers * config_.min_inliers;
  if (sighting) vouch(estimate.utime, estimate.T_odom_body);
  if (keeps || (sighting && !tracker_.is_worn(frame.pairs, *sighting))) return;
  unsettled_ = Unsettled{view.left.clone(),       view.right.clone(),     view.camera,
                         std::move(view.pyramid), std::move(frame.pairs), std::move(sighting)};
}

Result<void> StereoOdometry::settle() {
  if (!unsettled_) return {};
  Unsettled due = std::move(*unsettled_);
  unsettled_.reset();
  try {
    View view{due.left, due.right, due.camera, std::move(due.pyramid)};
    if (!tracker_.renew(view, T_odom_body_, due.pairs, due.sighting)) return {};
  } catch (const cv::Exception& exception) {
    return fail(std::string("odometry: ") + exception.what());
  }
  if (!due.sighting) vouch(utime_, T_odom_body_);
  if (anchor_ && anchor_->utime == utime_) anchor_->body.covariance.setZero();
  return {};
}

void StereoOdometry::vouch(Utime utime, const Isometry& T_odom_body) {
  T_odom_vouched_ = T_odom_body;
  vouched_utime_ = utime;
}

std::optional<Sighting> StereoOdometry::see(const View& view, Frame& frame) const {
  const Isometry T_odom_camera_expected = frame.T_odom_body_predicted * view.camera.T_body_camera;
  frame.pairs = tracker_.follow(view, T_odom_camera_expected);
  frame.estimate.tracked = static_cast<int>(frame.pairs.size());
  auto sighting = tracker_.locate(frame.pairs, T_odom_camera_expected, config_.min_inliers);
  if (sighting) {
    frame.estimate.inliers = sighting->pose.inliers;
    const Twist twist = twist_since_vouched(sighting->body.T_odom_body, frame.estimate.utime);
    if (!believable(twist)) sighting.reset();
  }
  return frame.prior ? judge(std::move(sighting), T_odom_camera_expected, frame) : sighting;
}

std::optional<Sighting> StereoOdometry::judge(std::optional<Sighting> sighting,
                                              const Isometry& T_odom_camera_expected,
                                              Frame& frame) const {
  if (!sighting) return std::nullopt;
  frame.agreed = frame.prior->agreed_with(sighting->body);
  if (frame.agreed) return sighting;
  auto second = tracker_.locate_by_the_rest(frame.pairs, *sighting, T_odom_camera_expected,
                                            config_.min_inliers / 2);
  if (second) frame.agreed = frame.prior->agreed_with(second->body);
  if (frame.agreed) {
    frame.estimate.dispute = Dispute::kMoverLeftOut;
    return second;
  }
  const int inliers = sighting->pose.inliers;
  const bool mover_about =
      mover_utime_ && frame.estimate.utime - *mover_utime_ <= kMoverRemembered_us;
  if (!mover_about && inliers >= kStrongInliers * config_.min_inliers &&
      inliers >= kStrongShare * static_cast<double>(frame.pairs.size())) {
    frame.estimate.dispute = Dispute::kTracksOverruled;
    return sighting;
  }
  frame.estimate.dispute = Dispute::kSightOverruled;
  return std::nullopt;
}

void StereoOdometry::take_seen(const Sighting& sighting, Frame& frame) const {
  OdometryEstimate& estimate = frame.estimate;
  const Belief& body = frame.agreed ? *frame.agreed : sighting.body;
  estimate.basis = frame.agreed ? Basis::kBoth : Basis::kSight;
  estimate.T_odom_body = body.T_odom_body;
  estimate.step_covariance = frame.covariance = body.covariance;
  estimate.inliers = sighting.pose.inliers;
  estimate.quality = quality(estimate.tracked, estimate.inliers);
  if (frame.agreed) estimate.quality = std::max(estimate.quality, kTracksQuality);
  estimate.twist = twist_since_vouched(body.T_odom_body, estimate.utime);
  if (!frame.step || anchor_->seen) return;
  // The step ends a way that nobody saw: where it began is as uncertain as that.
  estimate.step_covariance +=
      covariance_in(frame.step->T_from_to.inverse(), anchor_->body.covariance);
  if (frame.agreed)
    estimate.twist = twist_of(frame.step->T_from_to, to_seconds(estimate.utime - anchor_->utime));
}

void StereoOdometry::take_unseen(Frame& frame) const {
  if (frame.prior) return take_by_tracks(frame);
  if (started_) return coast(frame);
  frame.estimate.step_covariance = Matrix6d::Identity() * kFirstPoseSigma * kFirstPoseSigma;
}

void StereoOdometry::take_by_tracks(Frame& frame) const {
  OdometryEstimate& estimate = frame.estimate;
  estimate.basis = Basis::kTracks;
  estimate.quality = kTracksQuality;
  estimate.T_odom_body = frame.prior->alone().T_odom_body;
  estimate.twist = twist_of(frame.step->T_from_to, to_seconds(estimate.utime - anchor_->utime));
  estimate.step_covariance = frame.step->covariance;
  frame.covariance = frame.prior->alone().covariance;
  // What sight has just contradicted, or what ends a guess, is no better than a guess.
  Matrix6d doubt = Matrix6d::Zero();
  if (!tracks_trusted_) doubt += coasting_covariance(frame.dt_s);
  if (anchor_->utime != utime_) doubt += coasting_covariance(to_seconds(utime_ - anchor_->utime));
  estimate.step_covariance += doubt;
  frame.covariance += doubt;
}

void StereoOdometry::coast(Frame& frame) const {
  OdometryEstimate& estimate = frame.estimate;
  const double moving_s = std::clamp(config_.coast_s - coasted_s_, 0.0, frame.dt_s);
  const double share = frame.dt_s > 0 ? moving_s / frame.dt_s : 0;
  estimate.coasting = true;
  estimate.T_odom_body = frame.T_odom_body_predicted;
  estimate.twist = share * twist_;
  estimate.step_covariance = frame.covariance = coasting_covariance(frame.dt_s);
}

void StereoOdometry::finish(const Tracks& tracks, const Frame& frame) {
  const OdometryEstimate& estimate = frame.estimate;
  coasted_s_ = estimate.coasting ? coasted_s_ + frame.dt_s : 0;
  if (!estimate.coasting) twist_ = estimate.twist;
  T_odom_body_ = estimate.T_odom_body;
  utime_ = estimate.utime;
  started_ = true;
  resumed_ = false;
  const bool seen = estimate.basis == Basis::kSight || estimate.basis == Basis::kBoth;
  if (estimate.dispute == Dispute::kMoverLeftOut) mover_utime_ = utime_;
  if (frame.prior && seen) tracks_trusted_ = estimate.dispute != Dispute::kTracksOverruled;
  if (tracks) anchor_ = Anchor{utime_, *tracks, {T_odom_body_, frame.covariance}, seen};
}

Isometry StereoOdometry::predicted_body(double dt_s) const {
  const double moving_s = std::clamp(config_.coast_s - coasted_s_, 0.0, dt_s);
  return T_odom_body_ * motion_of(twist_, moving_s);
}

Matrix6d StereoOdometry::coasting_covariance(double dt_s) const {
  // The body may have gone on as it did, or stopped, or sped up.
  const double way_m = twist_.head<3>().norm() * dt_s + config_.coast_accel_mps2 * dt_s * dt_s / 2;
  const double turn_rad =
      twist_.tail<3>().norm() * dt_s + config_.coast_turn_accel_radps2 * dt_s * dt_s / 2;
  Vector6d variance;
  variance << Eigen::Vector3d::Constant(way_m * way_m),
      Eigen::Vector3d::Constant(turn_rad * turn_rad);
  variance.array() += kFirstPoseSigma * kFirstPoseSigma;
  return variance.asDiagonal();
}

Twist StereoOdometry::twist_since_vouched(const Isometry& T_odom_body, Utime utime) const {
  return twist_of(T_odom_vouched_.inverse() * T_odom_body, to_seconds(utime - vouched_utime_));
}

bool StereoOdometry::believable(const Twist& twist) const {
  return twist.allFinite() && twist.head<3>().norm() <= config_.max_speed_mps &&
         twist.tail<3>().norm() <= config_.max_turn_radps;
}

double StereoOdometry::quality(int tracked, int inliers) const {
  if (tracked == 0) return 0;
  const double share = static_cast<double>(inliers) / tracked;
  return std::min(1.0, inliers / kGoodInliers) * std::min(1.0, share / kGoodShare);
}

Checkpoint StereoOdometry::checkpoint() const {
  Checkpoint checkpoint{utime_, epoch_, T_odom_body_, twist_, std::nullopt};
  if (anchor_ && anchor_->utime == utime_) checkpoint.tracks = anchor_->moment.reading;
  return checkpoint;
}

void StereoOdometry::resume(const Checkpoint& checkpoint, const Tracks& tracks) {
  tracker_.forget();
  unsettled_.reset();
  started_ = true;
  resumed_ = true;
  utime_ = checkpoint.utime;
  epoch_ = checkpoint.epoch;
  T_odom_body_ = rigid(checkpoint.T_odom_body);
  twist_ = checkpoint.twist;
  coasted_s_ = 0;
  tracks_trusted_ = true;
  anchor_.reset();
  if (tracks) anchor_ = Anchor{utime_, *tracks, {T_odom_body_, Matrix6d::Zero()}, true};
}

}  // namespace cairn::odometry
