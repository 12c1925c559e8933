// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "evaluation/report.hpp"
#include "evaluation/trajectory.hpp"
#include "mapping/voxel_map.hpp"
#include "procs/simulator/simulator_config.hpp"

namespace cairn::cli {

/// The place of a simulated run as evaluation alone knows it: how much of its floor was seen, and
/// how well a map fits it. World, rig and robot are those of the simulator.
class SimulatedPlace {
 public:
  /// Surfaces of a map are scored within this.
  static constexpr double kTolerance_m = 0.05;

  /// Refuses what a simulator would refuse; an error names the world or rig file, and the line.
  /// What is so near that its disparity is larger than `max_disparity_px` need not be in a map.
  [[nodiscard]] static Result<SimulatedPlace> load(const SimulatorConfig& config,
                                                   double max_disparity_px);
  ~SimulatedPlace();
  SimulatedPlace(SimulatedPlace&&) noexcept;
  SimulatedPlace& operator=(SimulatedPlace&&) = delete;

  /// The robot was there.
  void visit(const Isometry& T_world_body);

  /// Share of the floor that the robot can reach from its start, that it has seen.
  [[nodiscard]] double coverage() const;

  /// Scores a map against all that was in view along the way.
  [[nodiscard]] Result<evaluation::MapReport> score(
      const mapping::VoxelMap& map, const Isometry& T_world_map,
      const evaluation::Trajectory& T_world_body) const;

 private:
  struct State;
  explicit SimulatedPlace(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace cairn::cli
