// SPDX-License-Identifier: Apache-2.0
#include "simulation/world.hpp"

#include <algorithm>
#include <limits>
#include <numbers>

namespace cairn::simulation {
namespace {

constexpr double kRadPerDeg = std::numbers::pi / 180;

Eigen::Vector3d vector3(const std::vector<double>& values) {
  return {values[0], values[1], values[2]};
}

/// Closed form: the distance to the nearest point of the box outside, minus the distance to the
/// nearest face inside.
double signed_distance_m(const Box& box, const Eigen::Vector3d& point_world) {
  const Eigen::Vector3d point_box = box.T_world_box.inverse() * point_world;
  const Eigen::Vector3d beyond = point_box.cwiseAbs() - box.half_size_m;
  return beyond.cwiseMax(0.0).norm() + std::min(beyond.maxCoeff(), 0.0);
}

Result<void> check_materials(const std::vector<Material>& materials, const std::string& name) {
  for (std::size_t i = 0; i < materials.size(); ++i) {
    const Material& material = materials[i];
    const std::string key = name + ": materials[" + std::to_string(i) + "].";
    if (material.name.empty()) return fail(key + "name: is missing");
    if (material.fine_m > material.coarse_m) return fail(key + "fine_m: is over coarse_m");
    for (std::size_t j = 0; j < i; ++j) {
      if (materials[j].name == material.name) {
        return fail(key + "name: '" + material.name + "' stands here twice");
      }
    }
  }
  return {};
}

Result<Box> make_box(const BoxConfig& config, const std::vector<Material>& materials,
                     const std::string& key) {
  if (config.centre_m.empty()) return fail(key + "centre_m: is missing");
  if (config.size_m.empty()) return fail(key + "size_m: is missing");
  const auto material = std::find_if(materials.begin(), materials.end(), [&](const Material& one) {
    return one.name == config.material;
  });
  if (material == materials.end()) {
    return fail(key + "material: '" + config.material + "' is not one of the materials");
  }
  Box box;
  box.name = config.name;
  box.T_world_box.linear() =
      rotation_from_rpy(config.rpy_deg[0] * kRadPerDeg, config.rpy_deg[1] * kRadPerDeg,
                        config.rpy_deg[2] * kRadPerDeg);
  box.T_world_box.translation() = vector3(config.centre_m);
  box.half_size_m = 0.5 * vector3(config.size_m);
  box.material = static_cast<std::size_t>(material - materials.begin());
  return box;
}

}  // namespace

double World::distance_m(const Eigen::Vector3d& point_world) const {
  double nearest_m = std::numeric_limits<double>::infinity();
  for (const Box& box : boxes) {
    nearest_m = std::min(nearest_m, signed_distance_m(box, point_world));
  }
  return nearest_m;
}

Result<World> make_world(const WorldConfig& config, const std::string& name) {
  if (const auto ok = check_materials(config.materials, name); !ok) {
    return tl::make_unexpected(ok.error());
  }
  if (config.boxes.empty()) return fail(name + ": boxes: there are none");
  World world;
  world.lamp_m = vector3(config.lamp_m);
  world.ambient = config.ambient;
  world.materials = config.materials;
  for (std::size_t i = 0; i < config.boxes.size(); ++i) {
    auto box =
        make_box(config.boxes[i], config.materials, name + ": boxes[" + std::to_string(i) + "].");
    if (!box) return tl::make_unexpected(box.error());
    world.boxes.push_back(std::move(*box));
  }
  return world;
}

Result<World> load_world(const std::filesystem::path& file) {
  const auto config = load_yaml<WorldConfig>(file);
  if (!config) return tl::make_unexpected(config.error());
  return make_world(*config, file.string());
}

}  // namespace cairn::simulation
