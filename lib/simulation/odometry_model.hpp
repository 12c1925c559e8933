// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>

#include "core/geometry.hpp"
#include "core/time.hpp"

namespace cairn::simulation {

/// What a visual odometry in good health would have made of a true motion: small errors at each
/// step, as much as it moves, and a scale of way and of turn that is a little off in each run. The
/// numbers were measured on drives through rendered rooms (procs/simulator/README.md). It never
/// fails. The same arguments give the same motion.
class OdometryModel {
 public:
  explicit OdometryModel(std::uint64_t seed);

  struct Step {
    Isometry T_odom_body = Isometry::Identity();
    Eigen::Vector3d linear_mps = Eigen::Vector3d::Zero();     ///< in body axes, since the last step
    Eigen::Vector3d angular_radps = Eigen::Vector3d::Zero();  ///< likewise
    Eigen::Matrix<double, 6, 1> variance = Eigen::Matrix<double, 6, 1>::Zero();  ///< of the step
  };

  /// The odometry frame is the body at the first call.
  [[nodiscard]] Step step(const Isometry& T_world_body, Utime utime);

 private:
  std::uint64_t seed_;
  double way_scale_;
  double turn_scale_;
  std::uint64_t steps_ = 0;
  std::optional<Isometry> T_world_last_;
  Utime last_utime_ = 0;
  Isometry T_odom_body_ = Isometry::Identity();
};

}  // namespace cairn::simulation
