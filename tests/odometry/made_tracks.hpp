// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>

#include "odometry/track_kinematics.hpp"

namespace cairn::testing {

/// Encoders of a robot whose tracks go `left_m`, `right_m` (of the time in seconds), read every 20
/// ms, as motor reports them; ticks are whole ones.
class MadeTracks {
 public:
  using Way = std::function<odometry::TrackWay(double seconds)>;

  explicit MadeTracks(Way way, const odometry::TrackConfig& config = {})
      : way_{std::move(way)}, history_{RobotConfig{}, config} {}

  /// What the encoders say at `utime`.
  [[nodiscard]] odometry::TrackReading reading(Utime utime) const;

  /// Where the tracks were at `utime`, by the readings up to 40 ms before.
  [[nodiscard]] std::optional<odometry::TrackHistory::Moment> at(Utime utime);

 private:
  Way way_;
  odometry::TrackHistory history_;
  Utime next_ = 0;
};

/// Tracks of a body with this gauge at a steady speed and turn, each longer or shorter by its slip:
/// 0.3 means that the encoder counts 30 % more than the body went.
[[nodiscard]] MadeTracks::Way steady_tracks(double speed_mps, double turn_radps,
                                            double left_slip = 0, double right_slip = 0);

}  // namespace cairn::testing
