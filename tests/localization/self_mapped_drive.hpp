// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <vector>

#include "evaluation/trajectory.hpp"
#include "localization/localizer.hpp"
#include "rendered_map.hpp"

namespace cairn::testing {

/// How odometry sees a true step of the body: what it says, and how sure it is of it.
using OdometryStep = std::function<localization::Motion(const Isometry& T_from_to)>;

/// Stereo odometry: errs at random, and by `drift` of the way and of the turn always the same way.
[[nodiscard]] OdometryStep stereo_like(double drift, unsigned seed);

/// Tracks alone, with fixed gauge; the right one slips by `slip` of its way, which its encoder does
/// not see. The covariance is what lib/odometry gives tracks.
[[nodiscard]] OdometryStep slipping_tracks(double slip);

struct DriveResult {
  std::vector<Isometry> truth;     ///< T_start_body
  std::vector<Isometry> odometry;  ///< T_odom_body
  std::vector<Isometry> poses;     ///< T_map_body as published
  std::vector<localization::Localizer::Pose> published;
  std::vector<double> update_ms;
  int late = 0;

  /// Largest and root mean square distance from the truth, and the last one [m].
  [[nodiscard]] static double rms_m(const std::vector<Isometry>& a, const std::vector<Isometry>& b);
  [[nodiscard]] static double end_m(const std::vector<Isometry>& a, const std::vector<Isometry>& b);
};

/// A robot that drives along `path` in a world at 15 Hz and knows nothing: it maps what it sees
/// from where its localizer says that it is, and the localizer looks at that map as of 8 frames
/// ago.
[[nodiscard]] DriveResult drive_and_map(const simulation::World& world,
                                        const std::vector<Isometry>& path,
                                        const OdometryStep& odometry, double resolution_m,
                                        double noise_px, unsigned seed,
                                        const localization::LocalizerConfig& config);

/// `laps` times along room_tour_m().
[[nodiscard]] std::vector<Isometry> room_tour(int laps, double speed_mps);

}  // namespace cairn::testing
