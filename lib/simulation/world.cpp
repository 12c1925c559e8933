// SPDX-License-Identifier: Apache-2.0
#include "simulation/world.hpp"

#include <algorithm>
#include <limits>
#include <numbers>

#include "simulation/wall.hpp"

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

Result<std::size_t> material_named(const std::string& name, const std::vector<Material>& materials,
                                   const std::string& key) {
  const auto found = std::find_if(materials.begin(), materials.end(),
                                  [&](const Material& one) { return one.name == name; });
  if (found == materials.end()) {
    return fail(key + "material: '" + name + "' is not one of the materials");
  }
  return static_cast<std::size_t>(found - materials.begin());
}

/// The box before this one whose pictures it is to bear.
Result<std::size_t> box_named(const std::string& name, const Box& box,
                              const std::vector<Box>& earlier, const std::string& key) {
  const auto is_named = [&](const Box& one) { return one.name == name; };
  const auto found = std::find_if(earlier.begin(), earlier.end(), is_named);
  if (found == earlier.end()) {
    return fail(key + "looks_like: no box before this one is called '" + name + "'");
  }
  if (std::count_if(found, earlier.end(), is_named) > 1) {
    return fail(key + "looks_like: more than one box is called '" + name + "'");
  }
  if (!found->half_size_m.isApprox(box.half_size_m, 1e-9)) {
    return fail(key + "looks_like: '" + name + "' has another size");
  }
  return static_cast<std::size_t>(found - earlier.begin());
}

Result<Box> make_box(const BoxConfig& config, const World& world, const std::string& key) {
  if (config.centre_m.empty()) return fail(key + "centre_m: is missing");
  if (config.size_m.empty()) return fail(key + "size_m: is missing");
  Box box;
  box.name = config.name;
  box.T_world_box.linear() =
      rotation_from_rpy(config.rpy_deg[0] * kRadPerDeg, config.rpy_deg[1] * kRadPerDeg,
                        config.rpy_deg[2] * kRadPerDeg);
  box.T_world_box.translation() = vector3(config.centre_m);
  box.half_size_m = 0.5 * vector3(config.size_m);
  if (config.looks_like.empty()) {
    const auto material = material_named(config.material, world.materials, key);
    if (!material) return tl::make_unexpected(material.error());
    box.material = *material;
    box.pictures = world.boxes.size();
    return box;
  }
  if (!config.material.empty()) return fail(key + "material: stands beside looks_like");
  const auto model = box_named(config.looks_like, box, world.boxes, key);
  if (!model) return tl::make_unexpected(model.error());
  box.material = world.boxes[*model].material;
  box.pictures = world.boxes[*model].pictures;
  return box;
}

Result<void> add_boxes(const WorldConfig& config, const std::string& name, World& world) {
  for (std::size_t i = 0; i < config.boxes.size(); ++i) {
    auto box = make_box(config.boxes[i], world, name + ": boxes[" + std::to_string(i) + "].");
    if (!box) return tl::make_unexpected(box.error());
    world.boxes.push_back(std::move(*box));
  }
  return {};
}

Result<void> add_walls(const WorldConfig& config, const std::string& name, World& world) {
  for (std::size_t i = 0; i < config.walls.size(); ++i) {
    const std::string key = name + ": walls[" + std::to_string(i) + "].";
    const auto material = material_named(config.walls[i].material, world.materials, key);
    if (!material) return tl::make_unexpected(material.error());
    auto pieces = wall_pieces(config.walls[i], key);
    if (!pieces) return tl::make_unexpected(pieces.error());
    for (Box& piece : *pieces) {
      piece.material = *material;
      piece.pictures = world.boxes.size();
      world.boxes.push_back(std::move(piece));
    }
  }
  return {};
}

Result<void> add_people(const WorldConfig& config, const std::string& name, World& world) {
  for (std::size_t i = 0; i < config.people.size(); ++i) {
    const PersonConfig& person = config.people[i];
    const std::string key = name + ": people[" + std::to_string(i) + "].";
    if (person.waypoints.size() < 2) return fail(key + "waypoints: are fewer than two");
    world.people.push_back({person.name, person.speed_mps, person.radius_m, person.height_m, {}});
    for (std::size_t k = 0; k < person.waypoints.size(); ++k) {
      const std::vector<double>& at_m = person.waypoints[k].at_m;
      if (at_m.empty()) return fail(key + "waypoints[" + std::to_string(k) + "].at_m: is missing");
      world.people.back().waypoints_m.emplace_back(at_m[0], at_m[1]);
    }
  }
  return {};
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
  if (config.boxes.empty() && config.walls.empty()) return fail(name + ": boxes: there are none");
  World world;
  world.lamp_m = vector3(config.lamp_m);
  world.ambient = config.ambient;
  world.materials = config.materials;
  world.T_world_start.linear() = rotation_from_rpy(0, 0, config.start.heading_deg * kRadPerDeg);
  world.T_world_start.translation() << config.start.at_m[0], config.start.at_m[1], 0;
  for (const auto add : {add_boxes, add_walls, add_people}) {
    if (const auto ok = add(config, name, world); !ok) return tl::make_unexpected(ok.error());
  }
  return world;
}

Result<World> load_world(const std::filesystem::path& file) {
  const auto config = load_yaml<WorldConfig>(file);
  if (!config) return tl::make_unexpected(config.error());
  return make_world(*config, file.string());
}

}  // namespace cairn::simulation
