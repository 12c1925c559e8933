// SPDX-License-Identifier: Apache-2.0
#include "evaluation/trajectory_score.hpp"

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>

namespace cairn::evaluation {
namespace {

constexpr std::int64_t kFrameTimeRounding_us = 1'000;
/// Positions whose spread across the way is under a thousandth of that along it fix no rotation
/// about it.
constexpr double kStraightVarianceRatio = 1e-6;
constexpr double kStandingVariance_m2 = 1e-12;
constexpr double kOrientationWeight = 1e-3;

/// Index of the pose nearest to `utime`; the earlier of two as near. `poses` is not empty.
std::size_t nearest(std::span<const StampedPose> poses, Utime utime) {
  const auto after =
      std::lower_bound(poses.begin(), poses.end(), utime,
                       [](const StampedPose& pose, Utime wanted) { return pose.utime < wanted; });
  if (after == poses.begin()) return 0;
  const auto index = static_cast<std::size_t>(after - poses.begin());
  if (after == poses.end()) return index - 1;
  return utime - poses[index - 1].utime <= after->utime - utime ? index - 1 : index;
}

/// True way from the first pair to each pair [m].
std::vector<double> way_m(std::span<const PosePair> pairs) {
  std::vector<double> way(pairs.size(), 0.0);
  for (std::size_t i = 1; i < pairs.size(); ++i) {
    way[i] = way[i - 1] + (pairs[i].truth.translation() - pairs[i - 1].truth.translation()).norm();
  }
  return way;
}

Isometry relative_error(const PosePair& from, const PosePair& to) {
  const Isometry true_motion = from.truth.inverse() * to.truth;
  return true_motion.inverse() * (from.estimate.inverse() * to.estimate);
}

/// RMS of the relative errors of (i, end_of(i)); end_of gives pairs.size() where there is none.
template <class EndOf>
std::optional<RelativeError> relative_rms(std::span<const PosePair> pairs, const EndOf& end_of) {
  RelativeError sum;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const std::size_t j = end_of(i);
    if (j >= pairs.size()) break;
    const Isometry E = relative_error(pairs[i], pairs[j]);
    const double angle_rad = rotation_angle_rad(E.linear());
    sum.translation_rmse_m += E.translation().squaredNorm();
    sum.rotation_rmse_rad += angle_rad * angle_rad;
    ++sum.count;
  }
  if (sum.count == 0) return std::nullopt;
  const auto count = static_cast<double>(sum.count);
  return RelativeError{sum.count, std::sqrt(sum.translation_rmse_m / count),
                       std::sqrt(sum.rotation_rmse_rad / count)};
}

Eigen::Matrix3d rotation_of_positions(std::span<const PosePair> pairs,
                                      const Eigen::Vector3d& truth_mean,
                                      const Eigen::Vector3d& estimate_mean) {
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d orientations = Eigen::Matrix3d::Zero();
  for (const PosePair& pair : pairs) {
    covariance += (pair.truth.translation() - truth_mean) *
                  (pair.estimate.translation() - estimate_mean).transpose();
    orientations += pair.truth.linear() * pair.estimate.linear().transpose();
  }
  covariance /= static_cast<double>(pairs.size());
  orientations /= static_cast<double>(pairs.size());
  const Eigen::Vector3d spread = Eigen::JacobiSVD<Eigen::Matrix3d>(covariance).singularValues();
  if (spread(0) < kStandingVariance_m2) return nearest_rotation(orientations);
  if (spread(1) < kStraightVarianceRatio * spread(0)) {
    covariance += kOrientationWeight * spread(0) * orientations;
  }
  return nearest_rotation(covariance);
}

}  // namespace

std::vector<PosePair> associate(std::span<const StampedPose> estimate,
                                std::span<const StampedPose> truth,
                                std::int64_t max_difference_us) {
  std::vector<PosePair> pairs;
  if (estimate.empty() || truth.empty()) return pairs;
  for (std::size_t i = 0; i < estimate.size(); ++i) {
    const std::size_t j = nearest(truth, estimate[i].utime);
    if (std::abs(truth[j].utime - estimate[i].utime) > max_difference_us) continue;
    if (nearest(estimate, truth[j].utime) != i) continue;
    pairs.push_back({estimate[i].utime, estimate[i].T, truth[j].T});
  }
  return pairs;
}

Isometry align(std::span<const PosePair> pairs, Alignment alignment) {
  if (alignment == Alignment::kFirstPose) {
    return pairs.front().truth * pairs.front().estimate.inverse();
  }
  Eigen::Vector3d truth_mean = Eigen::Vector3d::Zero();
  Eigen::Vector3d estimate_mean = Eigen::Vector3d::Zero();
  for (const PosePair& pair : pairs) {
    truth_mean += pair.truth.translation();
    estimate_mean += pair.estimate.translation();
  }
  truth_mean /= static_cast<double>(pairs.size());
  estimate_mean /= static_cast<double>(pairs.size());
  Isometry T = Isometry::Identity();
  T.linear() = rotation_of_positions(pairs, truth_mean, estimate_mean);
  T.translation() = truth_mean - T.linear() * estimate_mean;
  return T;
}

Isometry align_maps(std::span<const PosePair> pairs) {
  Eigen::Vector3d truth_mean = Eigen::Vector3d::Zero();
  Eigen::Vector3d estimate_mean = Eigen::Vector3d::Zero();
  for (const PosePair& pair : pairs) {
    truth_mean += pair.truth.translation() / static_cast<double>(pairs.size());
    estimate_mean += pair.estimate.translation() / static_cast<double>(pairs.size());
  }
  Eigen::Matrix3d both = Eigen::Matrix3d::Zero();
  for (const PosePair& pair : pairs) {
    both += (pair.truth.translation() - truth_mean) *
                (pair.estimate.translation() - estimate_mean).transpose() +
            kMapLever_m * kMapLever_m * pair.truth.linear() * pair.estimate.linear().transpose();
  }
  Isometry T = Isometry::Identity();
  T.linear() = nearest_rotation(both);
  T.translation() = truth_mean - T.linear() * estimate_mean;
  return T;
}

ErrorStatistics statistics(std::vector<double> errors) {
  std::sort(errors.begin(), errors.end());
  ErrorStatistics result;
  result.count = errors.size();
  double sum_of_squares = 0;
  for (const double error : errors) {
    result.mean += error;
    sum_of_squares += error * error;
  }
  const auto count = static_cast<double>(errors.size());
  result.mean /= count;
  result.rmse = std::sqrt(sum_of_squares / count);
  result.median = 0.5 * (errors[(errors.size() - 1) / 2] + errors[errors.size() / 2]);
  result.max = errors.back();
  return result;
}

ErrorStatistics absolute_error_m(std::span<const PosePair> pairs,
                                 const Isometry& T_truth_estimate) {
  std::vector<double> errors;
  errors.reserve(pairs.size());
  for (const PosePair& pair : pairs) {
    errors.push_back(
        (pair.truth.translation() - T_truth_estimate * pair.estimate.translation()).norm());
  }
  return statistics(std::move(errors));
}

std::optional<RelativeError> relative_error_over_distance(std::span<const PosePair> pairs,
                                                          double distance_m) {
  const std::vector<double> way = way_m(pairs);
  return relative_rms(pairs, [&](std::size_t i) {
    return static_cast<std::size_t>(std::lower_bound(way.begin(), way.end(), way[i] + distance_m) -
                                    way.begin());
  });
}

std::optional<RelativeError> relative_error_over_time(std::span<const PosePair> pairs,
                                                      std::int64_t duration_us) {
  return relative_rms(pairs, [&](std::size_t i) {
    const Utime wanted = pairs[i].utime + duration_us - kFrameTimeRounding_us;
    return static_cast<std::size_t>(
        std::lower_bound(pairs.begin(), pairs.end(), wanted,
                         [](const PosePair& pair, Utime t) { return pair.utime < t; }) -
        pairs.begin());
  });
}

std::vector<double> kitti_lengths_m() { return {100, 200, 300, 400, 500, 600, 700, 800}; }

std::vector<double> indoor_lengths_m() { return {1, 2, 3, 4, 5, 6, 7, 8}; }

std::optional<Drift> drift(std::span<const PosePair> pairs, std::span<const double> lengths_m,
                           std::size_t start_step) {
  const std::vector<double> way = way_m(pairs);
  Drift sum;
  for (std::size_t first = 0; first < pairs.size(); first += start_step) {
    for (const double length_m : lengths_m) {
      const auto last = std::upper_bound(way.begin(), way.end(), way[first] + length_m);
      if (last == way.end()) continue;
      const Isometry E =
          relative_error(pairs[first], pairs[static_cast<std::size_t>(last - way.begin())]);
      sum.translation_percent += 100.0 * E.translation().norm() / length_m;
      sum.rotation_deg_per_m +=
          rotation_angle_rad(E.linear()) * 180.0 / std::numbers::pi / length_m;
      ++sum.count;
    }
  }
  if (sum.count == 0) return std::nullopt;
  sum.translation_percent /= static_cast<double>(sum.count);
  sum.rotation_deg_per_m /= static_cast<double>(sum.count);
  return sum;
}

EndError end_error(std::span<const PosePair> pairs) {
  const Isometry T_truth_estimate = align(pairs, Alignment::kFirstPose);
  const PosePair& last = pairs.back();
  const Isometry aligned = T_truth_estimate * last.estimate;
  EndError error;
  error.position_m = (aligned.translation() - last.truth.translation()).norm();
  error.yaw_rad = yaw_rad(last.truth.inverse() * aligned);
  const double length_m = true_length_m(pairs);
  if (length_m > 0) error.fraction_of_way = error.position_m / length_m;
  return error;
}

double true_length_m(std::span<const PosePair> pairs) { return way_m(pairs).back(); }

Result<TrajectoryScore> score_trajectory(std::span<const StampedPose> estimate,
                                         std::span<const StampedPose> truth) {
  const std::vector<PosePair> pairs = associate(estimate, truth);
  if (pairs.size() < 2) {
    return fail("trajectories of " + std::to_string(estimate.size()) + " and " +
                std::to_string(truth.size()) + " poses share " + std::to_string(pairs.size()) +
                " moments (within " + std::to_string(kMaxAssociation_us / 1000) +
                " ms); 2 are needed");
  }
  TrajectoryScore score;
  score.pairs = pairs.size();
  score.length_m = true_length_m(pairs);
  score.duration_s = to_seconds(pairs.back().utime - pairs.front().utime);
  score.T_truth_estimate = align(pairs, Alignment::kLeastSquares);
  score.ate_m = absolute_error_m(pairs, score.T_truth_estimate);
  score.ate_first_pose_m = absolute_error_m(pairs, align(pairs, Alignment::kFirstPose));
  score.rpe_1m = relative_error_over_distance(pairs, 1.0);
  score.rpe_1s = relative_error_over_time(pairs, kMicrosecondsPerSecond);
  score.drift_kitti = drift(pairs, kitti_lengths_m());
  score.drift_indoor = drift(pairs, indoor_lengths_m());
  score.end = end_error(pairs);
  return score;
}

}  // namespace cairn::evaluation
