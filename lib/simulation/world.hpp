// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "core/geometry.hpp"
#include "core/result.hpp"
#include "simulation/world_config.hpp"

namespace cairn::simulation {

/// A solid box.
struct Box {
  std::string name;
  Isometry T_world_box = Isometry::Identity();  ///< box frame: in its middle, along its edges
  Eigen::Vector3d half_size_m = Eigen::Vector3d::Zero();
  std::size_t material = 0;  ///< index into World::materials
  std::size_t pictures = 0;  ///< index into World::boxes: whose pictures its sides bear
};

/// Somebody who walks in a loop.
struct Person {
  std::string name;
  double speed_mps = 0;
  double radius_m = 0;
  double height_m = 0;
  std::vector<Eigen::Vector2d> waypoints_m;  ///< at least two
};

/// A place: solid boxes, and nothing else; and who may come there. World frame: x, y level, z up;
/// the floor's top is at z = 0 by custom.
struct World {
  Eigen::Vector3d lamp_m = Eigen::Vector3d::Zero();
  double ambient = 1;
  std::vector<Material> materials;
  std::vector<Box> boxes;
  Isometry T_world_start = Isometry::Identity();  ///< of the robot's body, on z = 0
  std::vector<Person> people;

  /// Distance to the nearest surface [m]; negative inside a box. Exact outside; inside at most the
  /// true depth.
  [[nodiscard]] double distance_m(const Eigen::Vector3d& point_world) const;
};

/// Checks what the config says against itself: `name` begins each error.
[[nodiscard]] Result<World> make_world(const WorldConfig& config, const std::string& name);

/// Reads a world file; errors name file, line and key, or file and key.
[[nodiscard]] Result<World> load_world(const std::filesystem::path& file);

}  // namespace cairn::simulation
