// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "core/config.hpp"
#include "core/geometry.hpp"
#include "core/result.hpp"

namespace cairn::simulation {

/// What a surface looks like. Every face gets a picture of its own from the seed: cloudy noise,
/// patches with sharp edges, and regular joints.
struct Material {
  std::string name;
  int seed = 1;
  double brightness = 0.5;
  double noise_contrast = 0.15;
  double coarse_m = 0.4;
  double fine_m = 0.01;
  double patch_contrast = 0.2;
  double patch_m = 0.1;
  double patches_per_m2 = 20;
  std::vector<double> joint_m = {0, 0};
  double joint_contrast = 0.3;

  void visit(ConfigVisitor& v) {
    v.text("name", name, "what boxes call it");
    v.integer("seed", seed, 0, 1'000'000, "", "another seed, another picture");
    v.number("brightness", brightness, {0.02, 1}, "", "share of the light that it gives back");
    v.number("noise_contrast", noise_contrast, {0, 1}, "",
             "standard deviation of the cloudy noise, as a share of the brightness");
    v.number("coarse_m", coarse_m, {0.01, 10}, "m", "size of the noise's largest clouds");
    v.number("fine_m", fine_m, {0.002, 10}, "m", "size of its smallest, not over coarse_m");
    v.number("patch_contrast", patch_contrast, {0, 1}, "",
             "how far a patch may be brighter or darker, as a share of the brightness");
    v.number("patch_m", patch_m, {0.005, 5}, "m", "size of a patch");
    v.number("patches_per_m2", patches_per_m2, {0, 10'000}, "1/m2", "how many patches there are");
    v.numbers("joint_m", joint_m, 2, 2, {0, 10}, "m",
              "distances of the joints along the face's two axes; 0: none");
    v.number("joint_contrast", joint_contrast, {0, 1}, "",
             "how much darker a joint is, as a share of the brightness");
  }
};

/// A solid box as the file gives it.
struct BoxConfig {
  std::string name;
  std::vector<double> centre_m;
  std::vector<double> size_m;
  std::vector<double> rpy_deg = {0, 0, 0};
  std::string material;

  void visit(ConfigVisitor& v) {
    v.text("name", name, "what it is, for people");
    v.numbers("centre_m", centre_m, 3, 3, {-1000, 1000}, "m", "its middle: x, y, z (up)");
    v.numbers("size_m", size_m, 3, 3, {0.001, 1000}, "m", "its whole extent before it is turned");
    v.numbers("rpy_deg", rpy_deg, 3, 3, {-360, 360}, "deg", "roll, pitch, yaw");
    v.text("material", material, "name of one of the materials");
  }
};

/// A world file (config/worlds/README.md).
struct WorldConfig {
  std::vector<double> lamp_m = {0, 0, 2.3};
  double ambient = 0.6;
  std::vector<Material> materials;
  std::vector<BoxConfig> boxes;

  void visit(ConfigVisitor& v) {
    v.numbers("lamp_m", lamp_m, 3, 3, {-1000, 1000}, "m", "where the lamp hangs");
    v.number("ambient", ambient, {0, 1}, "", "share of the light that comes from everywhere");
    v.list("materials", materials, "what surfaces look like");
    v.list("boxes", boxes, "all there is: floor, walls, furniture");
  }
};

/// A solid box.
struct Box {
  std::string name;
  Isometry T_world_box = Isometry::Identity();  ///< box frame: in its middle, along its edges
  Eigen::Vector3d half_size_m = Eigen::Vector3d::Zero();
  std::size_t material = 0;  ///< index into World::materials
};

/// A place: solid boxes, and nothing else. World frame: x, y level, z up; the floor's top is at z =
/// 0 by custom.
struct World {
  Eigen::Vector3d lamp_m = Eigen::Vector3d::Zero();
  double ambient = 1;
  std::vector<Material> materials;
  std::vector<Box> boxes;

  /// Distance to the nearest surface [m]; negative inside a box. Exact outside; inside at most the
  /// true depth.
  [[nodiscard]] double distance_m(const Eigen::Vector3d& point_world) const;
};

/// Checks what the config says against itself: `name` begins each error.
[[nodiscard]] Result<World> make_world(const WorldConfig& config, const std::string& name);

/// Reads a world file; errors name file, line and key, or file and key.
[[nodiscard]] Result<World> load_world(const std::filesystem::path& file);

}  // namespace cairn::simulation
