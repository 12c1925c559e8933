// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <random>
#include <string>

#include "camera/rig_calibration.hpp"
#include "localization/distance_field.hpp"
#include "localization/refinement.hpp"
#include "localization/surface.hpp"
#include "mapping/map_delta.hpp"
#include "mapping/map_replica.hpp"
#include "mapping/ray_integrator.hpp"
#include "mapping/voxel_map.hpp"
#include "simulation/depth_renderer.hpp"
#include "simulation/world.hpp"
#include "stereo/disparity_image.hpp"

namespace cairn::testing {

/// A world of config/worlds, by its name.
[[nodiscard]] simulation::World world_named(const std::string& name);

/// A body pose on the floor.
[[nodiscard]] Isometry on_floor(double x_m, double y_m, double yaw_rad);

/// The simulated robot's eyes in a world: true depth as disparity, with normal noise, and no answer
/// where stereo could give none (nearer than 0.73 m, beyond the right image, at the edges of
/// things, and here and there).
class NoisyEyes {
 public:
  NoisyEyes(const simulation::World& world, double noise_px, unsigned seed);
  [[nodiscard]] stereo::DisparityImage look(const Isometry& T_world_body, Utime utime);
  [[nodiscard]] const stereo::RectifiedCamera& camera() const { return camera_; }

 private:
  stereo::RectifiedCamera camera_;
  std::unique_ptr<simulation::DepthRenderer> depth_;
  double noise_px_;
  std::mt19937 random_;
};

/// A mapper and a reader of its map in one.
class OwnMap {
 public:
  explicit OwnMap(double resolution_m) : map_{resolution_m} {}

  void see(const stereo::DisparityImage& image, const Isometry& T_map_body);
  /// What became different since the last time.
  [[nodiscard]] mapping::MapDelta delta(Utime utime);
  /// Tells the copy.
  void tell(Utime utime) { (void)replica.apply(delta(utime)).value(); }

  mapping::MapReplica replica;

 private:
  mapping::VoxelMap map_;
  mapping::RayIntegrator integrator_{mapping::RayIntegratorConfig{}};
  std::vector<mapping::BrickIndex> changed_;
};

/// A copy with the field that is derived from it.
struct Fielded {
  localization::DistanceField field;
  localization::Surfaces surfaces;

  void take_all(mapping::MapReplica& map) {
    field.take(map, map.take_changes());
    while (field.behind() > 0) (void)field.work({}, 1000);
  }
};

}  // namespace cairn::testing
