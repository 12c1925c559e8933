// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <optional>
#include <string>

#include "core/config.hpp"
#include "core/robot.hpp"
#include "core/time.hpp"
#include "planning/ground_memory.hpp"
#include "planning/ground_view.hpp"
#include "stereo/disparity_image.hpp"

namespace cairn::planning {

struct ClearanceConfig {
  GroundConfig ground;
  double side_margin_m = 0.10;
  double front_margin_m = 0.10;
  double reaction_s = 0.35;
  double creep_mps = 0.1;
  double memory_s = 2;
  double slow_memory_s = 30;
  double slow_mps = 0.3;
  double obstacle_memory_s = 30;
  double sight_hole_s = 0.3;

  void visit(ConfigVisitor& v) {
    v.group("ground", ground, "what counts as floor");
    v.number("side_margin_m", side_margin_m, {0, 1}, "m", "beside the body that must be free, too");
    v.number("front_margin_m", front_margin_m, {0, 2}, "m", "left free before the body at a stop");
    v.number("reaction_s", reaction_s, {0, 5}, "s",
             "from the image until the tracks begin to brake");
    v.number("creep_mps", creep_mps, {0, 1}, "m/s",
             "on near floor that was seen longer than slow_memory_s ago, and where it began");
    v.number("memory_s", memory_s, {0, 60}, "s", "floor seen this long ago is as good as new");
    v.number("slow_memory_s", slow_memory_s, {0, 120}, "s",
             "floor seen this long ago is good for slow_mps");
    v.number("slow_mps", slow_mps, {0, 5}, "m/s", "on floor seen longer than memory_s ago");
    v.number("obstacle_memory_s", obstacle_memory_s, {0, 600}, "s",
             "an obstacle that went out of sight stays for this long");
    v.number("sight_hole_s", sight_hole_s, {0, 2}, "s",
             "floor that is looked at may go unseen for this long");
  }
};

/// Permission to move forward.
struct Permission {
  double max_forward_mps = 0;
  std::string reason;  ///< what limits it, in words; "free" if nothing does
};

/// One reading of a distance sensor.
struct RangeReading {
  Utime utime = 0;
  Eigen::Isometry2d T_body_sensor = Eigen::Isometry2d::Identity();  ///< x along the beam
  double range_m = 0;
  double half_angle_rad = 0;
};

/// How fast the robot may move forward, by what was seen of the ground before it and nothing else.
///
/// The strip that it would sweep (its width and a margin, along the arc that it drives) up to where
/// it would stand still (v * reaction + v^2 / (2 acceleration) + margin) must have been seen to be
/// floor, by images up to memory_s old: fast; up to slow_memory_s old: at slow_mps at most, so that
/// the robot can get going at all, as its cameras see the floor only from some way ahead. Floor
/// that the cameras never had in sight allows creep_mps. Whatever the speed, floor or an obstacle
/// must be seen right now, on every lane of the strip, where the cameras' sight of the floor
/// begins: if not, something hides it, or nothing can be told.
class Clearance {
 public:
  Clearance(const ClearanceConfig& config, const RobotConfig& robot);

  /// Adds an image, taken at T_start_body by the tracks.
  void see(const stereo::DisparityImage& image, const Eigen::Isometry2d& T_start_body);
  /// Adds a distance sensor's reading of something. A cone blocks the whole arc that it covers.
  void measure(const RangeReading& reading, const Eigen::Isometry2d& T_start_body);
  /// Forgets everything: it is not known any more where it was.
  void forget();

  /// What is allowed at T_start_body while the robot turns at turn_radps.
  [[nodiscard]] Permission judge(Utime now, const Eigen::Isometry2d& T_start_body,
                                 double turn_radps) const;

  [[nodiscard]] const GroundView& view() const { return view_; }

 private:
  /// Made for every spot of the strip, so it is put into words only when somebody asks.
  struct Limit {
    double max_mps;
    const char* what;
    std::optional<double> ahead_m = {};
    const char* after = "";
    [[nodiscard]] std::string reason() const;
  };
  [[nodiscard]] Limit spot_limit(const Eigen::Vector2d& at_body_m, Utime now,
                                 const Eigen::Isometry2d& T_start_body) const;
  [[nodiscard]] bool floor_in_sight(double y_m, const Eigen::Isometry2d& T_start_body) const;
  [[nodiscard]] bool hidden_by_something_known(const Eigen::Vector2d& from_m,
                                               const Eigen::Vector2d& to_m,
                                               const Eigen::Isometry2d& T_start_body) const;
  [[nodiscard]] bool lane_in_sight(double y_m, const Eigen::Isometry2d& T_start_body) const;
  [[nodiscard]] Limit sight_limit(const Eigen::Isometry2d& T_start_body) const;
  [[nodiscard]] Limit sweep_limit(double speed_mps, double turn_radps, Utime now,
                                  const Eigen::Isometry2d& T_start_body) const;

  ClearanceConfig config_;
  RobotConfig robot_;
  GroundView view_;
  GroundMemory memory_;
  std::optional<Utime> seen_utime_;
  Eigen::Vector2d began_at_m_ = Eigen::Vector2d::Zero();  ///< in the standing frame
  std::array<Eigen::Vector2d, 2> eyes_m_;  ///< of the newest image; in the body frame, from above
};

}  // namespace cairn::planning
