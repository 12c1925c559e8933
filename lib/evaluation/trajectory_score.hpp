// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/geometry.hpp"
#include "core/result.hpp"
#include "evaluation/trajectory.hpp"

namespace cairn::evaluation {

/// An estimated pose P and the true pose Q of the same moment.
struct PosePair {
  Utime utime = 0;  ///< of the estimate
  Isometry estimate = Isometry::Identity();
  Isometry truth = Isometry::Identity();
};

inline constexpr std::int64_t kMaxAssociation_us = 10'000;

/// Pairs of poses that are nearest to each other in time, and no farther apart than
/// `max_difference_us`.
[[nodiscard]] std::vector<PosePair> associate(std::span<const StampedPose> estimate,
                                              std::span<const StampedPose> truth,
                                              std::int64_t max_difference_us = kMaxAssociation_us);

/// How the estimate's frame is laid over the truth's.
enum class Alignment {
  kLeastSquares,  ///< all positions, SE(3), no scale (Umeyama 1991, eq. 40-43 with c = 1)
  kFirstPose,     ///< the first pair exactly
};

/// T_truth_estimate of the pairs (at least one). Where the positions leave a rotation open (a
/// straight way, a stand), the orientations decide it.
[[nodiscard]] Isometry align(std::span<const PosePair> pairs, Alignment alignment);

/// A shorter way says nothing of a rotation, nor of a share of it.
inline constexpr double kShortestWay_m = 1;

/// What a map shows lies about so far from the robot: a turn is weighed as what it moves there.
inline constexpr double kMapLever_m = 1;

/// T_truth_estimate (of at least one pair) to lay maps over each other by: least squares over whole
/// poses, positions and, kMapLever_m along each axis from them, what the orientations say.
/// Positions alone would let a map tilt about a way that is almost straight, by the noise of its
/// width. (Umeyama 1991, eq. 40-43 with c = 1, for these points.)
[[nodiscard]] Isometry align_maps(std::span<const PosePair> pairs);

struct ErrorStatistics {
  std::size_t count = 0;
  double rmse = 0;
  double mean = 0;
  double median = 0;  ///< of an even count: the mean of the middle two
  double max = 0;
};
/// Of at least one error.
[[nodiscard]] ErrorStatistics statistics(std::vector<double> errors);

/// Absolute trajectory error (Sturm et al. 2012): |q_i - T_truth_estimate p_i| [m].
[[nodiscard]] ErrorStatistics absolute_error_m(std::span<const PosePair> pairs,
                                               const Isometry& T_truth_estimate);

/// Relative pose error, E_i = inv(inv(Q_i) Q_j) * inv(P_i) P_j (Sturm et al. 2012).
struct RelativeError {
  std::size_t count = 0;
  double translation_rmse_m = 0;
  double rotation_rmse_rad = 0;
};
/// j is the first pair that is `distance_m` of true way after i. Nothing if the way is shorter.
[[nodiscard]] std::optional<RelativeError> relative_error_over_distance(
    std::span<const PosePair> pairs, double distance_m);
/// j is the first pair that is `duration_us` after i, or at most 1 ms less: frame times are
/// rounded.
[[nodiscard]] std::optional<RelativeError> relative_error_over_time(std::span<const PosePair> pairs,
                                                                    std::int64_t duration_us);

/// Drift as in the KITTI odometry benchmark (Geiger et al. 2012): for each length and every tenth
/// start, the relative error to the first pair that lies farther than this length of true way,
/// divided by the length; the mean of all.
struct Drift {
  std::size_t count = 0;
  double translation_percent = 0;
  double rotation_deg_per_m = 0;
};
/// The benchmark's own lengths, for streets [m].
[[nodiscard]] std::vector<double> kitti_lengths_m();
/// 1 to 8 m, for rooms: to be labelled "indoor-KITTI".
[[nodiscard]] std::vector<double> indoor_lengths_m();
/// Nothing if no sub-sequence is long enough.
[[nodiscard]] std::optional<Drift> drift(std::span<const PosePair> pairs,
                                         std::span<const double> lengths_m,
                                         std::size_t start_step = 10);

/// What the estimate is off by at the last pair, when laid over the truth at the first pair alone.
/// Body poses.
struct EndError {
  double position_m = 0;
  double yaw_rad = 0;  ///< estimate less truth, about the body's z, in (-pi, pi]
  std::optional<double>
      fraction_of_way;  ///< position_m / length of the true way; nothing on a way of 0 m
};
/// Of at least one pair.
[[nodiscard]] EndError end_error(std::span<const PosePair> pairs);

/// Length of the true way through the pairs [m].
[[nodiscard]] double true_length_m(std::span<const PosePair> pairs);

/// Everything above, of one run.
struct TrajectoryScore {
  std::size_t pairs = 0;
  double length_m = 0;
  double duration_s = 0;
  Isometry T_truth_estimate = Isometry::Identity();  ///< least squares
  ErrorStatistics ate_m;                             ///< aligned by least squares
  ErrorStatistics ate_first_pose_m;                  ///< aligned at the first pose
  std::optional<RelativeError> rpe_1m;
  std::optional<RelativeError> rpe_1s;
  std::optional<Drift> drift_kitti;
  std::optional<Drift> drift_indoor;
  EndError end;
};
/// Refuses when no two poses belong together.
[[nodiscard]] Result<TrajectoryScore> score_trajectory(std::span<const StampedPose> estimate,
                                                       std::span<const StampedPose> truth);

}  // namespace cairn::evaluation
