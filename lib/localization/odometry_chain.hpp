// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>

#include "core/config.hpp"
#include "core/geometry.hpp"
#include "core/time.hpp"
#include "localization/pose_change.hpp"

namespace cairn::localization {

/// One frame as odometry tells it.
struct OdometryFrame {
  Utime utime = 0;
  Isometry T_odom_body = Isometry::Identity();
  Matrix6d step_covariance = Matrix6d::Zero();  ///< of the motion since the frame before, body axes
  std::int32_t epoch = 0;
};

struct MotionConfig {
  double drift_m = 0.005;
  double drift_rad = 0.003;
  double turn_share = 0.01;
  double blind_speed_mps = 0.3;
  double blind_turn_radps = 0.6;

  void visit(ConfigVisitor& v) {
    v.number(
        "drift_m", drift_m, {0, 1}, "m",
        "how far odometry errs per metre, at least (one sigma; grows with the root of the way)");
    v.number("drift_rad", drift_rad, {0, 1}, "rad", "how far its heading errs per metre, likewise");
    v.number("turn_share", turn_share, {0, 1}, "rad", "and per radian turned, likewise");
    v.number("blind_speed_mps", blind_speed_mps, {0, 5}, "m/s",
             "how fast the robot may have moved while there was no odometry (one sigma)");
    v.number("blind_turn_radps", blind_turn_radps, {0, 10}, "rad/s",
             "how fast it may have turned, likewise");
  }
};

/// How the body moved from one frame to the next.
struct Motion {
  Isometry T_from_to = Isometry::Identity();
  Matrix6d covariance = Matrix6d::Zero();  ///< of T_from_to, axes of `to`
  Matrix6d claimed = Matrix6d::Zero();     ///< what odometry itself says of that
  bool jumped = false;                     ///< unseen: a new epoch in a frame of its own
};

/// Odometry's frames as one chain of motion, free of jumps. A new epoch whose pose goes on from the
/// last one (odometry was restarted, and remembered) is taken at its word. One that begins at the
/// identity, or farther off than the body was fast, lies in a frame of its own: the body is taken
/// to be where it was, and what it may have done unseen widens the covariance.
class OdometryChain {
 public:
  explicit OdometryChain(const MotionConfig& config) : config_{config} {}

  /// The motion since the frame before; frames must come in order. The first one gives no motion.
  [[nodiscard]] Motion put(const OdometryFrame& frame);

  /// Of the chain's frame, which never jumps: T_chain_body of the last frame.
  [[nodiscard]] const Isometry& T_chain_body() const { return T_chain_body_; }
  /// Of the present epoch.
  [[nodiscard]] const Isometry& T_chain_odom() const { return T_chain_odom_; }
  [[nodiscard]] const std::optional<OdometryFrame>& last() const { return last_; }

  /// Goes on from there.
  void restore(const Isometry& T_chain_odom, const OdometryFrame& last);

 private:
  [[nodiscard]] bool begins_anew(const OdometryFrame& frame, const Isometry& T_from_to,
                                 double gap_s) const;

  MotionConfig config_;
  std::optional<OdometryFrame> last_;
  double speed_mps_ = 0;
  double turn_radps_ = 0;
  Isometry T_chain_odom_ = Isometry::Identity();
  Isometry T_chain_body_ = Isometry::Identity();
};

}  // namespace cairn::localization
