// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <deque>
#include <optional>

#include "core/config.hpp"
#include "core/robot.hpp"
#include "core/time.hpp"
#include "odometry/motion.hpp"

namespace cairn::odometry {

/// How far from rigid wheels tracks are.
struct TrackConfig {
  double effective_gauge_ratio = 1;
  double slip_sigma = 0.15;

  void visit(ConfigVisitor& v) {
    v.number("effective_gauge_ratio", effective_gauge_ratio, {0.5, 4}, "",
             "distance of the tracks' instantaneous centres of rotation over track_gauge_m: above "
             "1 where tracks slip sideways as they turn");
    v.number("slip_sigma", slip_sigma, {0, 1}, "",
             "share of a track's way that slip may take or add (one sigma)");
  }
};

/// What the encoders said at one time.
struct TrackReading {
  Utime utime = 0;
  std::int64_t left_ticks = 0;
  std::int64_t right_ticks = 0;
  double ticks_per_m = 1;
  double left_mps = 0;
  double right_mps = 0;
};

/// How far the tracks went.
struct TrackWay {
  double left_m = 0;
  double right_m = 0;
};

/// The motion of a body on two tracks by their instantaneous centres of rotation, which lie
/// symmetrically at +-gauge / 2 and are carried by no sideways slip (Martinez et al. 2005, eq. 1,
/// with y_l = -y_r = gauge / 2, x_v = 0): turn = (right - left) / gauge about a centre on the
/// y axis.
[[nodiscard]] Eigen::Isometry2d track_motion(const TrackWay& way, double gauge_m);

/// Covariance of track_motion as a motion of the body in space (order as in Twist), with each
/// track's way off by `slip_sigma` of itself, and a little for what a floor does to a body beside.
[[nodiscard]] Matrix6d track_covariance(const TrackWay& way, double gauge_m, double slip_sigma);

/// A planar motion as one in space, z, roll and pitch untouched.
[[nodiscard]] Isometry in_space(const Eigen::Isometry2d& T);

/// Where the tracks say that the body is, over the last seconds. Readings go in by rising utime;
/// what comes out for a moment rests on those up to kLag_us before it, by their utime alone, so
/// that it does not matter when they arrive (DESIGN rule 4).
class TrackHistory {
 public:
  /// A frame k counts with the readings up to utime_k less this.
  static constexpr std::int64_t kLag_us = 40'000;
  /// A newest reading this much older than a moment says nothing about it.
  static constexpr std::int64_t kSilence_us = 200'000;
  /// Ticks bridge a gap between readings up to this.
  static constexpr std::int64_t kBridge_us = 5 * kMicrosecondsPerSecond;

  TrackHistory(const RobotConfig& robot, const TrackConfig& config)
      : gauge_m_{robot.track_gauge_m * config.effective_gauge_ratio},
        max_speed_mps_{robot.max_speed_mps} {}

  /// What became of a reading.
  enum class Added {
    kOn,      ///< the chain goes on
    kAfresh,  ///< a chain begins
    kNot,     ///< it was not newer than the newest
  };

  /// Ignores what is not newer than the newest. The chain of motion breaks, and all that was before
  /// is forgotten, where ticks jump by more than the tracks can do (the controller started anew),
  /// after a gap over kBridge_us, and where utime goes back by over a second.
  Added add(const TrackReading& reading);

  /// What the tracks did up to a moment.
  struct Moment {
    Eigen::Isometry2d T_start_body = Eigen::Isometry2d::Identity();  ///< since the chain's start
    TrackWay way;          ///< since the chain's start, as T_start_body; backwards counts negative
    TrackReading reading;  ///< the reading that it rests on
    std::int64_t chain = 0;  ///< moments of different chains have nothing to do with each other
  };
  /// At `utime`: by the newest reading up to kLag_us before it, and from there at its speeds.
  /// Nothing if there is no such reading, or it is kSilence_us older than that.
  [[nodiscard]] std::optional<Moment> at(Utime utime) const;
  /// By the newest reading of all, where it stands.
  [[nodiscard]] std::optional<Moment> newest() const;
  /// True if all readings that count for `utime` are there, or none is to be waited for: the newest
  /// is over kSilence_us older than `now`, and whoever listens has done so for that long.
  [[nodiscard]] bool ready_for(Utime utime, Utime now) const;
  /// Before this nobody listened: readings older than that came from somebody's memory.
  void listens_from(Utime utime) { listens_from_ = utime; }

  [[nodiscard]] double gauge_m() const { return gauge_m_; }

 private:
  double gauge_m_;
  double max_speed_mps_;
  Utime listens_from_ = 0;
  std::deque<Moment> moments_;
};

}  // namespace cairn::odometry
