// SPDX-License-Identifier: Apache-2.0
#include "simulation/person_look.hpp"

#include <cmath>
#include <numbers>

namespace cairn::simulation {
namespace {

// Of the height and the radius; lengths along, across and up.
constexpr double kHip = 0.48;
constexpr double kNeck = 0.86;
constexpr double kLegLength = 0.55;
constexpr double kLegWidth = 0.55;
constexpr double kLegApart = 0.36;
constexpr double kBodyLength = 0.85;
constexpr double kBodyWidth = 1.6;
constexpr double kHeadLength = 0.75;
constexpr double kHeadWidth = 0.6;
/// The feet reach this share of the radius forward and back.
constexpr double kSwing = 0.45;
constexpr double kStride_m = 1.3;

Box box_at(const Isometry& T_world_person, const Eigen::Vector3d& middle_m,
           const Eigen::Vector3d& size_m, std::size_t material) {
  Box box;
  box.T_world_box = T_world_person;
  box.T_world_box.translate(middle_m);
  box.half_size_m = 0.5 * size_m;
  box.material = material;
  return box;
}

/// A leg that hangs from the hip, turned forward by an angle.
Box leg(const Isometry& T_world_person, double side_m, double turn_rad, const Person& person) {
  const double hip_m = kHip * person.height_m;
  const double length_m = kLegLength * person.radius_m;
  // The foot's corners stay on or above the floor.
  const double reach_m =
      (hip_m - 0.5 * length_m * std::abs(std::sin(turn_rad))) / std::cos(turn_rad);
  Isometry T_world_leg = T_world_person;
  T_world_leg.translate(Eigen::Vector3d(0, side_m, hip_m));
  T_world_leg.rotate(rotation_from_rpy(0, -turn_rad, 0));
  return box_at(T_world_leg, {0, 0, -0.5 * reach_m},
                {length_m, kLegWidth * person.radius_m, reach_m}, 0);
}

Material cloth(std::size_t person, int seed, double brightness, double patch_contrast) {
  Material material;
  material.seed = 1000 + 10 * static_cast<int>(person) + seed;
  material.brightness = brightness;
  material.noise_contrast = 0.2;
  material.coarse_m = 0.1;
  material.fine_m = 0.004;
  material.patch_contrast = patch_contrast;
  material.patch_m = 0.06;
  material.patches_per_m2 = 120;
  return material;
}

}  // namespace

std::vector<Box> person_boxes(const Person& person, const PersonPose& pose) {
  const double radius_m = person.radius_m;
  const double height_m = person.height_m;
  Isometry T_world_person = Isometry::Identity();
  T_world_person.translation() << pose.at_m.x(), pose.at_m.y(), 0;
  T_world_person.linear() = rotation_from_rpy(0, 0, pose.heading_rad);
  const double swing_rad = std::asin(kSwing * radius_m / (kHip * height_m)) *
                           std::sin(2 * std::numbers::pi * pose.walked_m / kStride_m);
  const double leg_m = kLegApart * radius_m;
  return {leg(T_world_person, leg_m, swing_rad, person),
          leg(T_world_person, -leg_m, -swing_rad, person),
          box_at(T_world_person, {0, 0, 0.5 * (kHip + kNeck) * height_m},
                 {kBodyLength * radius_m, kBodyWidth * radius_m, (kNeck - kHip) * height_m}, 1),
          box_at(T_world_person, {0, 0, 0.5 * (kNeck + 1) * height_m},
                 {kHeadLength * radius_m, kHeadWidth * radius_m, (1 - kNeck) * height_m}, 2)};
}

std::vector<Box> people_boxes(std::span<const Person> people, std::span<const PersonPose> poses) {
  std::vector<Box> boxes;
  for (const PersonPose& pose : poses) {
    if (pose.person >= people.size()) continue;
    const auto parts = person_boxes(people[pose.person], pose);
    boxes.insert(boxes.end(), parts.begin(), parts.end());
  }
  return boxes;
}

std::vector<Material> person_materials(std::size_t person) {
  const double shade = 0.25 + 0.1 * static_cast<double>(person % 4);
  return {cloth(person, 1, shade, 0.3), cloth(person, 2, 0.7 - shade, 0.5),
          cloth(person, 3, 0.5, 0.2)};
}

}  // namespace cairn::simulation
