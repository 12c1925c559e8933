// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "core/robot.hpp"
#include "odometry/belief.hpp"
#include "odometry/track_kinematics.hpp"

namespace cairn::odometry {

/// What is known of the tracks beforehand.
struct TrackModel {
  TrackModel() : TrackModel(RobotConfig{}, TrackConfig{}) {}
  TrackModel(const RobotConfig& robot, const TrackConfig& config)
      : gauge_m{robot.track_gauge_m * config.effective_gauge_ratio},
        slip_sigma{config.slip_sigma},
        max_acceleration_mps2{robot.max_acceleration_mps2} {}

  double gauge_m;
  double slip_sigma;
  double max_acceleration_mps2;
};

/// The body between two moments, by the tracks alone.
struct TrackStep {
  Isometry T_from_to = Isometry::Identity();
  TrackWay way;
  /// track_covariance of the way.
  Matrix6d covariance = Matrix6d::Zero();
  /// How far each track may be from where it was reckoned after the last readings (one sigma):
  /// nothing that adds up from step to step.
  double unread_m = 0;

  /// Neither track moved by over a millimetre.
  [[nodiscard]] bool stands() const;
};

/// Nothing if the moments belong to different chains.
[[nodiscard]] std::optional<TrackStep> track_step(const TrackHistory::Moment& from,
                                                  Utime from_utime, const TrackHistory::Moment& to,
                                                  Utime to_utime, const TrackModel& model);

/// What the tracks make of a belief that is a step old, held against what is seen. Tracks say
/// where the body is on the floor: x, y and yaw; where they stand, they say that all six stay.
class TrackPrior {
 public:
  TrackPrior(const Belief& before, const TrackStep& step, const TrackModel& model);

  /// By the tracks alone.
  [[nodiscard]] const Belief& alone() const { return alone_; }

  /// Both beliefs weighted by their information; nothing if they contradict each other (chi-square,
  /// 6 degrees of freedom, 99.9 %). Tracks that stand are believed to a tenth of a millimetre as
  /// long as sight allows it. Slip lasts: within 0.3 m of way its errors are one error, so there a
  /// step weighs as little as its share of that way.
  [[nodiscard]] std::optional<Belief> agreed_with(const Belief& seen) const;

 private:
  Belief alone_;
  std::optional<Belief> standing_;  ///< if the tracks stand as they say
  Belief strict_;                   ///< with their errors as they are in one step
  Belief lasting_;                  ///< with their errors as they add up over many
};

}  // namespace cairn::odometry
