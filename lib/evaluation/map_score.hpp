// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/geometry.hpp"
#include "core/result.hpp"

namespace cairn::evaluation {

/// Distance from a point of the world to the nearest true surface [m]; negative inside matter where
/// the world knows inside from outside. May fall short of the true distance, never exceed it
/// (1-Lipschitz).
using DistanceFunction = std::function<double(const Eigen::Vector3d&)>;

/// Distance to the nearest of sampled surface points (never negative), at most `limit_m`.
[[nodiscard]] DistanceFunction distance_to_samples(std::span<const Eigen::Vector3d> samples,
                                                   double limit_m);

/// What is true, in the world frame.
struct MapTruth {
  DistanceFunction distance_m;
  /// Points on true surfaces that the robot could have seen from where it was.
  std::vector<Eigen::Vector3d> observable_surface;
};

/// A cube of a map.
struct Voxel {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  ///< in the world frame, so after alignment [m]
  double size_m = 0;  ///< the resolution, or a multiple of it for a coarse level
};

struct MapScoreConfig {
  double resolution_m =
      0.01;  ///< of the finest level: everything is counted in voxels of this size
  double tolerance_m = 0.02;
};

/// Shares are fractions of 1; nothing where there was nothing to count.
///
/// "Within tolerance": no farther from the voxel's centre than tolerance_m + (size - resolution) /
/// 2; a coarse voxel gets the half extent that it has more. An occupied voxel counts for the
/// surface that it stands for, (size / resolution)^2; a free one for its volume.
struct MapScore {
  double resolution_m = 0;
  double tolerance_m = 0;
  std::optional<double> precision;  ///< of the occupied: within tolerance of a true surface
  std::optional<double>
      recall;  ///< of observable surface points: an occupied voxel is within tolerance
  /// TP / (TP + FP + FN): TP, FP the occupied that are precise and not, FN the resolution-sized
  /// voxels that hold observable surface points none of which is recalled.
  std::optional<double> iou;
  /// Of the free volume: what a true surface passes through (nearer to the centre than half a
  /// voxel) or lies in matter.
  std::optional<double> false_free_rate;
  std::uint64_t occupied_voxels = 0;  ///< as given
  std::uint64_t free_voxels = 0;      ///< of the finest size
};

/// Compares a map with the truth voxel by voxel, without holding the free ones.
class MapScorer {
 public:
  /// The truth must outlive the scorer.
  MapScorer(const MapTruth& truth, const MapScoreConfig& config);
  ~MapScorer();
  MapScorer(const MapScorer&) = delete;
  MapScorer& operator=(const MapScorer&) = delete;

  void add_occupied(const Voxel& voxel);
  void add_free(const Voxel& voxel);
  [[nodiscard]] MapScore score() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// The same from voxel centres of one resolution.
[[nodiscard]] MapScore score_map(const MapTruth& truth, const MapScoreConfig& config,
                                 std::span<const Eigen::Vector3d> occupied_centres,
                                 std::span<const Eigen::Vector3d> free_centres);

}  // namespace cairn::evaluation
