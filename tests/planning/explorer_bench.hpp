// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bench_pose.hpp"
#include "mapping/map_replica.hpp"
#include "mapping/projective_integrator.hpp"
#include "mapping/voxel_map.hpp"
#include "motor/track_pid.hpp"
#include "motor/track_speed.hpp"
#include "odometry/track_kinematics.hpp"
#include "planning/clearance.hpp"
#include "planning/navigator.hpp"
#include "simulation/disparity_model.hpp"
#include "simulation/floor_sight.hpp"
#include "simulation/playground.hpp"

namespace cairn::testing {

struct BenchConfig {
  double resolution_m = 0.04;
  int people = 0;
  unsigned seed = 1;
  PoseTrouble pose;
  /// What guard thinks of the tracks' gauge over what it is.
  double gauge_error = 1.05;
};

/// A robot in a world, with all delays of the group: the simulator's body and people, tracks under
/// PID, cameras, carving into a map that comes 8 frames late, guard's permission 20 times
/// a second by what it sees and by its tracks, and a Navigator. Frames at 15 Hz. The map's frame is
/// where the robot starts. One thread, seeded: the same arguments give the same run.
class ExplorerBench {
 public:
  ExplorerBench(const simulation::World& world, const BenchConfig& config,
                const planning::NavigatorConfig& navigation = {});

  /// One frame.
  void step();
  /// Until the navigator is idle, or for this long.
  void run(double at_most_s);

  [[nodiscard]] planning::Navigator& navigator() { return *navigator_; }
  /// Puts something into the world.
  void put(const simulation::Box& box);
  /// Changes what the robot is told of itself.
  std::function<void(planning::Situation&)> meddle;
  /// The mapper begins a new map, empty.
  void forget_map();
  /// The planner is killed, and begins anew with what it remembers.
  void restart_planner();

  [[nodiscard]] double time_s() const { return to_seconds(now_ - kStart); }
  [[nodiscard]] planning::Pose2 in_world() const;
  [[nodiscard]] Eigen::Vector2d to_map_m(const Eigen::Vector2d& point_world_m) const;
  [[nodiscard]] std::span<const simulation::PersonPose> people() const {
    return playground_->people();
  }
  /// What guard says now.
  [[nodiscard]] const planning::Permission& permission() const { return permission_; }
  /// Contacts begun while the robot moved at over 0.05 m/s.
  [[nodiscard]] std::int64_t collisions() const {
    return collisions_before_ + playground_->body().collisions();
  }
  [[nodiscard]] double driven_m() const { return driven_m_; }
  /// Share of the floor that the robot can reach which it has seen, in truth.
  [[nodiscard]] double coverage() const { return sight_->share(); }
  [[nodiscard]] const simulation::FloorSight& sight() const { return *sight_; }
  /// What the navigator said, when it changed, and collisions.
  [[nodiscard]] const std::vector<std::string>& diary() const { return diary_; }
  [[nodiscard]] std::string story() const;

  /// Host time that went into Navigator::step and into guard's looks and judgements [ms].
  struct Cost {
    std::vector<double> planner_ms;
    std::vector<double> guard_ms;
  };
  [[nodiscard]] const Cost& cost() const { return cost_; }

 private:
  static constexpr Utime kStart = 1'000'000;
  using Work = std::function<void()>;

  void make_playground();
  void open_eyes();
  void do_what_is_due();
  void later(std::int64_t after_us, Work work);
  void take_frame();
  void see(stereo::DisparityImage image);
  void judge();
  void plan(const planning::Situation& situation);
  void command();
  void drive_tracks();
  void map(const stereo::DisparityImage& image, const Isometry& T_map_body);
  void write_diary();
  void note(const std::string& line);

  BenchConfig config_;
  planning::NavigatorConfig navigation_;
  RobotConfig robot_;
  std::shared_ptr<const simulation::World> world_;
  Isometry T_map_world_;
  std::unique_ptr<simulation::Playground> playground_;
  std::unique_ptr<simulation::FloorSight> sight_;
  std::int64_t collisions_before_ = 0;
  std::int64_t left_ticks_before_ = 0;
  std::int64_t right_ticks_before_ = 0;
  std::unique_ptr<simulation::DisparityModel> eyes_;
  BenchPose pose_;
  std::unique_ptr<mapping::VoxelMap> map_;
  std::uint64_t map_id_ = 1;
  mapping::MapReplica replica_;
  struct Delta {
    std::int64_t frame;
    mapping::MapDelta delta;
  };
  std::deque<Delta> deltas_;
  mapping::ProjectiveIntegrator integrator_;
  odometry::TrackHistory tracks_;
  planning::Clearance guard_;
  Utime seen_utime_ = 0;
  planning::Permission permission_;
  std::unique_ptr<planning::Navigator> navigator_;

  struct Track {
    motor::TrackPid pid;
    motor::TrackSpeed speed;
    double commanded_mps = 0;
    double duty = 0;
  };
  Track left_;
  Track right_;
  planning::Drive command_;
  double permitted_mps_ = 0;  ///< as motor knows it
  double told_mps_ = 0;       ///< as planner knows it

  struct Due {
    Utime at;
    Work work;
  };
  std::vector<Due> due_;
  Utime now_ = kStart;
  std::int64_t frame_ = 0;
  double driven_m_ = 0;
  Cost cost_;
  std::vector<std::string> diary_;
  std::string last_said_;
  std::int64_t last_collisions_ = 0;
};

}  // namespace cairn::testing
