// SPDX-License-Identifier: Apache-2.0
#include "bench_pose.hpp"

#include <cmath>

namespace cairn::testing {

void BenchPose::move(const Isometry& T_map_body, double dt_s) {
  const planning::Pose2 truth = planning::from_above(T_map_body);
  if (last_) {
    planning::Pose2 step = planning::moved(planning::inverse(*last_), truth);
    step.at_m *= 1 + trouble_.odometry_drift;
    step.heading_rad *= 1 + trouble_.odometry_drift;
    in_odom_ = planning::moved(in_odom_, step);
  }
  last_ = truth;
  std::normal_distribution<double> normal;
  const double kept = std::exp(-dt_s / trouble_.memory_s);
  const double push = std::sqrt(1 - kept * kept);
  for (double& off : off_) off = kept * off + push * normal(random_);
  T_map_body_ = T_map_body;
  T_map_body_.pretranslate(Eigen::Vector3d(off_[0], off_[1], 0) * trouble_.off_m);
  T_map_body_.rotate(rotation_from_rpy(trouble_.tilt_rad * off_[3], trouble_.tilt_rad * off_[4],
                                       trouble_.off_rad * off_[2]));
}

}  // namespace cairn::testing
