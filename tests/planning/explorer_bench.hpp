// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "bench_world.hpp"
#include "mapping/map_replica.hpp"
#include "mapping/ray_integrator.hpp"
#include "mapping/voxel_map.hpp"
#include "planning/clearance.hpp"
#include "planning/navigator.hpp"

namespace cairn::testing {

struct BenchConfig {
  double resolution_m = 0.04;
  int image_width_px = 240;
  int image_height_px = 180;
  int frames_per_image = 2;
  double turn_slip = 0.1;  ///< share of each commanded turn that the tracks lose
  unsigned seed = 1;
};

/// A robot in a world of boxes: tracks that follow commands as fast as they can, a camera that
/// fills a map, guard's permission, and a Navigator that drives it. Frames at 15 Hz. The map's
/// frame is where the robot starts; it knows its pose exactly.
class ExplorerBench {
 public:
  ExplorerBench(const simulation::World& world, const BenchConfig& config,
                const planning::NavigatorConfig& navigation = {});

  /// One frame.
  void step();
  /// Until the navigator is idle, or for this long.
  void run(double at_most_s);

  [[nodiscard]] planning::Navigator& navigator() { return navigator_; }
  /// For worlds that change.
  [[nodiscard]] std::vector<simulation::Box>& boxes() { return boxes_; }
  /// Changes what the robot is told of itself.
  std::function<void(planning::Situation&)> meddle;

  [[nodiscard]] double time_s() const { return to_seconds(now_ - kStart); }
  [[nodiscard]] planning::Pose2 in_world() const { return robot_; }
  [[nodiscard]] planning::Pose2 in_map() const;
  [[nodiscard]] Eigen::Vector2d to_map_m(const Eigen::Vector2d& point_world_m) const;
  /// What guard says now.
  [[nodiscard]] const planning::Permission& permission() const { return permission_; }
  [[nodiscard]] int touches() const { return touches_; }
  [[nodiscard]] double driven_m() const { return driven_m_; }
  /// Share of the floor that the robot can reach which the navigator's map shows as free.
  [[nodiscard]] double coverage() const;
  /// What the navigator said, when it changed.
  [[nodiscard]] const std::vector<std::string>& diary() const { return diary_; }

 private:
  static constexpr Utime kStart = 1'000'000;
  void look();
  void move();
  void write_diary();

  BenchConfig config_;
  RobotConfig robot_config_;
  std::vector<simulation::Box> boxes_;
  planning::Pose2 start_;
  planning::Pose2 robot_;
  planning::Drive moving_;
  BenchEyes eyes_;
  mapping::VoxelMap map_;
  mapping::MapReplica replica_;
  mapping::RayIntegrator integrator_{mapping::RayIntegratorConfig{}};
  planning::Clearance guard_;
  planning::Permission permission_;
  planning::Navigator navigator_;
  planning::CellGrid<std::uint8_t> floor_;
  Utime now_ = kStart;
  int frame_ = 0;
  int touches_ = 0;
  double driven_m_ = 0;
  std::vector<std::string> diary_;
  std::string last_said_;
};

}  // namespace cairn::testing
