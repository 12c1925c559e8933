// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <filesystem>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "camera/rig_calibration.hpp"
#include "simulation/world.hpp"

namespace cairn::simulation {

/// One of the worlds that ship.
inline std::filesystem::path world_file(const std::string& name) {
  return std::filesystem::path(CAIRN_SOURCE_DIR) / "config" / "worlds" / (name + ".yaml");
}

inline std::filesystem::path room_file() { return world_file("room"); }

/// Two level cameras with a horizontal view of 60 degrees, 25.4 cm apart.
inline camera::RigCalibration test_rig(int width_px = 640, int height_px = 480) {
  Isometry T_body_left = Isometry::Identity();
  T_body_left.linear() = R_body_camera_forward();
  T_body_left.translation() = Eigen::Vector3d(0.1, 0.127, 0.45);
  const double f_px = 0.5 * width_px / std::tan(3.14159265358979323846 / 6);
  return camera::rectified_rig(f_px, f_px, 0.5 * (width_px - 1), 0.5 * (height_px - 1), 0.254,
                               width_px, height_px, T_body_left);
}

inline Isometry pose_2d(double x_m, double y_m, double yaw) {
  Isometry T = Isometry::Identity();
  T.linear() = rotation_from_rpy(0, 0, yaw);
  T.translation() = Eigen::Vector3d(x_m, y_m, 0);
  return T;
}

/// The rig of the simulated robot: lenses that bend, cameras a little turned.
inline camera::RigCalibration simulated_rig() {
  return camera::load_rig(std::string(CAIRN_SOURCE_DIR) + "/config/calibration/simulated-25cm.yaml")
      .value();
}

/// A random pose on z = 0 with nothing within a distance of a point 0.30 m above it, inside the
/// rectangle that the boxes' middles span.
inline Isometry free_pose(const World& world, double distance_m, std::mt19937& random) {
  Eigen::AlignedBox2d plan;
  for (const Box& box : world.boxes) {
    plan.extend(Eigen::Vector2d(box.T_world_box.translation().head<2>()));
  }
  std::uniform_real_distribution<double> unit(0, 1);
  for (;;) {
    const Eigen::Vector2d at =
        plan.min() + Eigen::Vector2d(unit(random), unit(random)).cwiseProduct(plan.sizes());
    const double heading = 2 * 3.14159265358979323846 * unit(random);
    if (world.distance_m({at.x(), at.y(), 0.3}) > distance_m) {
      return pose_2d(at.x(), at.y(), heading);
    }
  }
}

inline BoxConfig box(std::vector<double> centre_m, std::vector<double> size_m,
                     std::vector<double> rpy_deg = {0, 0, 0}) {
  BoxConfig config;
  config.centre_m = std::move(centre_m);
  config.size_m = std::move(size_m);
  config.rpy_deg = std::move(rpy_deg);
  config.material = "stuff";
  return config;
}

inline World world_of(std::vector<BoxConfig> boxes) {
  WorldConfig config;
  Material stuff;
  stuff.name = "stuff";
  config.materials.push_back(stuff);
  config.boxes = std::move(boxes);
  return make_world(config, "test").value();
}

}  // namespace cairn::simulation
