// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/config.hpp"
#include "core/robot.hpp"
#include "core/time.hpp"
#include "mapping/map_replica.hpp"
#include "planning/exploration.hpp"
#include "planning/ground_model.hpp"
#include "planning/path_follower.hpp"
#include "planning/plan_memory.hpp"
#include "planning/trail.hpp"

namespace cairn::planning {

struct NavigatorConfig {
  double unseen_radius_m = 0.8;
  double stuck_s = 4;
  double refused_s = 2.5;
  double settle_s = 0.8;
  double blocked_memory_s = 15;
  double back_off_m = 0.25;
  double back_off_mps = 0.15;
  TraversabilityConfig ground;
  RouteConfig route;
  ExplorationConfig exploration;
  FollowerConfig follower;

  void visit(ConfigVisitor& v) {
    v.number(
        "unseen_radius_m", unseen_radius_m, {0.1, 3}, "m",
        "around where the robot is put down, floor is taken for granted: the cameras see none");
    v.number("stuck_s", stuck_s, {0.5, 60}, "s", "without getting on: something blocks the way");
    v.number("refused_s", refused_s, {0.2, 60}, "s",
             "that guard may refuse to let it go forward: something blocks the way");
    v.number("settle_s", settle_s, {0, 10}, "s", "that the map takes to show what was looked at");
    v.number("blocked_memory_s", blocked_memory_s, {1, 3600}, "s",
             "what blocked the way unseen stays in the way for this long");
    v.number("back_off_m", back_off_m, {0, 2}, "m",
             "how far to back off at most, over ground that it has just driven forward on: nearer "
             "than this nobody comes to the back of a robot");
    v.number("back_off_mps", back_off_mps, {0.02, 0.5}, "m/s", "how fast");
    v.group("ground", ground, "what can be driven on");
    v.group("route", route, "what ways cost");
    v.group("exploration", exploration, "what is worth looking at");
    v.group("follower", follower, "how paths are followed");
  }
};

/// What the robot knows of itself at one frame.
struct Situation {
  Utime utime = 0;
  Pose2 in_odom;
  double forward_mps = 0;
  double turn_radps = 0;
  std::int32_t epoch = 0;  ///< of the odometry frame
  Pose2 T_map_odom;
  double height_m = 0;     ///< of the body in the map
  bool located = false;    ///< T_map_odom is known, for this epoch
  bool lost = false;       ///< where it is in the map is not known any more
  double allowed_mps = 0;  ///< forward, by guard
  bool latched = false;    ///< stopped by a person
  Utime map_through = 0;   ///< the map shows what was seen until then
  bool map_whole = false;  ///< nothing of mapper's map is known to be lacking in ours
};

struct PlanReport {
  Phase phase = Phase::kIdle;
  std::int64_t goal_id = 0;
  std::string reason = "nothing to do";
  double distance_left_m = 0;
  double eta_s = 0;
};

/// Decides where to go and how to move: explores, drives to goals, and gets itself out of trouble.
/// Knows the map and what the robot says of itself; no clock, no messages.
class Navigator {
 public:
  Navigator(const NavigatorConfig& config, const RobotConfig& robot);

  void explore(std::int64_t goal_id);
  void go(std::int64_t goal_id, const Destination& destination);
  void cancel(std::int64_t goal_id);

  /// One frame: `changes` is what became different in `map` since the frame before.
  void step(const Situation& now, const mapping::MapReplica& map,
            const mapping::MapReplica::Changes& changes);

  /// How to move at data time `now`; the pose is carried on by its velocity for at most 0.2 s, and
  /// after 0.4 s without a step the answer is zero.
  [[nodiscard]] Drive drive(Utime now);

  [[nodiscard]] const PlanReport& report() const { return report_; }
  /// The path being followed, in the odometry frame, and how often it was replaced.
  [[nodiscard]] const PlannedPath& path() const { return follower_.path(); }
  [[nodiscard]] std::int64_t path_count() const { return path_count_; }
  [[nodiscard]] bool idle() const { return mission_ == Mission::kNone; }
  [[nodiscard]] const GroundModel& ground_model() const { return model_; }

  [[nodiscard]] PlanMemory memory() const;
  void restore(PlanMemory memory);

 private:
  enum class Activity : std::uint8_t { kNone, kTurning, kSettling, kFollowing, kBackingOff, kLost };

  // The robot and its ground.
  [[nodiscard]] Pose2 in_map() const;
  void track();
  void count_way_behind(const Situation& next);
  void forget_place();
  void expire_blocked();

  // What to do next.
  void begin(Mission mission, std::int64_t goal_id);
  void decide(bool judged);
  void next();
  void next_view();
  void next_way();
  void explored(const RouteField& routes);
  [[nodiscard]] bool look_again(const CostGrid& costs, const RouteField& routes);
  void looked_again();
  void drop_target();
  void finish(Phase phase, const std::string& reason);
  void say(Phase phase, const std::string& reason);
  void reckon();

  // Ways.
  [[nodiscard]] CostGrid costs_from_here() const;
  [[nodiscard]] std::string why_not(Cell goal, const CostGrid& costs) const;
  void set_out(const CostGrid& costs, const std::vector<Cell>& route, const Destination& to);
  [[nodiscard]] bool way_is_good() const;
  void mend_way();

  [[nodiscard]] double safe_turn_radps() const;

  // Activities.
  void rest();
  void begin_turns(std::vector<double> turns_rad);
  void begin_settling();
  void go_on_turning();
  void go_on_settling();
  void go_on_following();
  void go_on_backing_off();

  // Trouble.
  void begin_progress();
  [[nodiscard]] bool getting_on();
  void recover();
  void take_as_blocked();
  [[nodiscard]] bool begin_backing_off();
  [[nodiscard]] bool aim_back();
  void give_up_target();
  void be_lost();

  NavigatorConfig config_;
  RobotConfig robot_;
  GroundModel model_;
  Exploration exploration_;
  PathFollower follower_;
  Trail trail_;

  Situation now_;
  bool stepped_ = false;
  bool judged_ = false;    ///< the ground, at the step before
  Utime map_here_by_ = 0;  ///< the map may take until then to come over the bus

  Mission mission_ = Mission::kNone;
  std::int64_t goal_id_ = 0;
  Destination destination_;
  PlanReport report_;
  bool looked_round_ = false;

  Activity activity_ = Activity::kNone;
  std::optional<Viewpoint> view_;  ///< that the robot is on its way to
  bool looked_ = false;            ///< at view_, in full
  int nothing_wanted_ = 0;         ///< times in a row

  Destination way_to_;  ///< of the path, in the map
  Pose2 planned_T_map_odom_;
  std::int64_t path_count_ = 0;
  Utime give_up_at_ = 0;

  std::vector<double> turns_rad_;  ///< to come, the next one last
  double last_heading_rad_ = 0;
  Utime turned_at_ = 0;  ///< towards what it wants to see; it stands since
  Utime settled_at_ = 0;
  std::vector<Eigen::Vector2d> way_back_m_;  ///< in the map; the next point last
  double behind_m_ = 0;  ///< driven forward and not yet back: free behind, up to back_off_m

  Drive moving_;
  Utime moving_since_ = 0;

  Pose2 progress_from_;
  Utime progress_at_ = 0;
  Utime allowed_at_ = 0;  ///< when guard last allowed what was wanted
  int recoveries_ = 0;
  Eigen::Vector2d recovered_at_m_ = Eigen::Vector2d::Zero();
  Utime lost_since_ = 0;
  Eigen::Vector2d lost_at_m_ = Eigen::Vector2d::Zero();
  struct Blocked {
    BlockedSpot spot;
    Utime until;
  };
  std::vector<Blocked> blocked_;
  std::optional<Eigen::Vector2d> looks_again_at_m_;  ///< blocked spot that it is on its way to see
  std::vector<Eigen::Vector2d> looked_again_at_m_;   ///< in this mission
};

}  // namespace cairn::planning
