// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <random>

#include "core/geometry.hpp"
#include "planning/pose2.hpp"

namespace cairn::testing {

/// How wrong the robot is about where it is.
struct PoseTrouble {
  double off_m = 0.02;           ///< one sigma along x and y of the pose in the map
  double off_rad = 0.008;        ///< and of its heading
  double tilt_rad = 0.002;       ///< of its roll and pitch
  double memory_s = 4;           ///< after which the error has become another
  double odometry_drift = 0.01;  ///< share of each way and turn
};

/// Plays odometry and localizer: a pose in the odometry frame that drifts, and one in the map that
/// wanders round the truth (an Ornstein-Uhlenbeck process).
class BenchPose {
 public:
  BenchPose(const PoseTrouble& trouble, unsigned seed) : trouble_{trouble}, random_{seed} {}

  /// The next frame: where the body truly is in the map's frame, and how long after the last.
  void move(const Isometry& T_map_body, double dt_s);

  [[nodiscard]] const planning::Pose2& in_odom() const { return in_odom_; }
  [[nodiscard]] planning::Pose2 T_map_odom() const {
    return planning::moved(planning::from_above(T_map_body_), planning::inverse(in_odom_));
  }
  /// As it is believed.
  [[nodiscard]] const Isometry& T_map_body() const { return T_map_body_; }

 private:
  PoseTrouble trouble_;
  std::mt19937 random_;
  std::optional<planning::Pose2> last_;
  planning::Pose2 in_odom_;
  Eigen::Matrix<double, 5, 1> off_ = Eigen::Matrix<double, 5, 1>::Zero();
  Isometry T_map_body_ = Isometry::Identity();
};

}  // namespace cairn::testing
