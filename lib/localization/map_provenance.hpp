// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "localization/distance_field.hpp"
#include "localization/pose_belief.hpp"
#include "localization/pose_change.hpp"
#include "localization/view.hpp"
#include "mapping/brick_grid.hpp"

namespace cairn::localization {

/// What a part of the map can say of the pose: no more than the robot knew when it made that part.
struct MapAuthority {
  /// Of the pose as it is, against the pose that the part in view was made from: how far odometry
  /// may have drifted since. Nothing is learned where this is nothing.
  Matrix6d drift = Matrix6d::Zero();
  /// How much each beam of the view counts, 0 to 1; empty: all count whole.
  std::vector<double> shares;
};

/// From which poses the map was made, as the localizer saw it come to be. A map that the robot
/// makes as it goes bears the errors of its own poses: a view that is held against what was mapped
/// a moment ago, from a pose with the same error, tells nothing. What was mapped at pose m corrects
/// pose t only by what odometry lost between the two. With e the errors of the poses, z = e_t - e_m
/// is what is measured, and cov(e_t, z) = P_t - P_m (a Kalman update whose noise is correlated with
/// the state: Schmidt 1966; Bar-Shalom, Li and Kirubarajan 2001, section 8.3).
///
/// What is found in the map where the robot never looked before was made by others, or in a former
/// run: it is the frame of reference.
class MapProvenance {
 public:
  /// All that is in the map by now, and is not of the robot's making, was made from poses as
  /// uncertain as this one.
  void start(const PoseBelief& reference);

  /// Notes what the view finds, at `belief`, and tells what that can say.
  [[nodiscard]] MapAuthority look(const DistanceField& field, const View& view,
                                  const PoseBelief& belief);

 private:
  using Origin = std::int32_t;
  /// The state of a place, a cube of some cells of the field.
  static constexpr Origin kNeverLooked = 0;
  static constexpr Origin kNothingThere = 1;
  static constexpr Origin kFirst = 2;  ///< and on: index of made_, plus this
  struct Places {
    Origin origin[mapping::kBrickVoxels] = {};
  };
  /// Of one pose from which map was made.
  struct Made {
    Eigen::Vector3d at_m;
    Matrix6d covariance;
  };

  [[nodiscard]] Origin origin_now(const PoseBelief& belief);

  mapping::BrickGrid<Places> places_;
  std::vector<Made> made_{{Eigen::Vector3d::Zero(), Matrix6d::Zero()}};
};

}  // namespace cairn::localization
