// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "core/config.hpp"

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
  std::string looks_like;

  void visit(ConfigVisitor& v) {
    v.text("name", name, "what it is, for people");
    v.numbers("centre_m", centre_m, 3, 3, {-1000, 1000}, "m", "its middle: x, y, z (up)");
    v.numbers("size_m", size_m, 3, 3, {0.001, 1000}, "m", "its whole extent before it is turned");
    v.numbers("rpy_deg", rpy_deg, 3, 3, {-360, 360}, "deg", "roll, pitch, yaw");
    v.text("material", material, "name of one of the materials");
    v.text(
        "looks_like", looks_like,
        "instead of a material: name of an earlier box of the same size, whose pictures this one "
        "bears side for side, turned as it is turned");
  }
};

/// An opening in a wall, from the floor up.
struct DoorConfig {
  double at_m = 0.5;
  double width_m = 0.9;
  double height_m = 2;

  void visit(ConfigVisitor& v) {
    v.number("at_m", at_m, {0, 1000}, "m", "from the wall's beginning to the opening's middle");
    v.number("width_m", width_m, {0.01, 100}, "m", "how wide the opening is");
    v.number("height_m", height_m, {0.01, 100}, "m", "how high it is");
  }
};

/// An upright wall on z = 0, with openings.
struct WallConfig {
  std::string name;
  std::vector<double> from_m;
  std::vector<double> to_m;
  double thickness_m = 0.1;
  double height_m = 2.5;
  std::string material;
  std::vector<DoorConfig> doors;

  void visit(ConfigVisitor& v) {
    v.text("name", name, "what it is, for people");
    v.numbers("from_m", from_m, 2, 2, {-1000, 1000}, "m", "x, y of its beginning, in its middle");
    v.numbers("to_m", to_m, 2, 2, {-1000, 1000}, "m", "x, y of its end, in its middle");
    v.number("thickness_m", thickness_m, {0.01, 10}, "m", "how thick it is");
    v.number("height_m", height_m, {0.01, 100}, "m", "how high it is");
    v.text("material", material, "name of one of the materials");
    v.list("doors", doors, "openings, in order along the wall");
  }
};

/// Where the robot begins.
struct StartConfig {
  std::vector<double> at_m = {0, 0};
  double heading_deg = 0;

  void visit(ConfigVisitor& v) {
    v.numbers("at_m", at_m, 2, 2, {-1000, 1000}, "m", "x, y of the middle between its tracks");
    v.number("heading_deg", heading_deg, {-360, 360}, "deg",
             "where it looks: 0 along x, 90 along y");
  }
};

struct WaypointConfig {
  std::vector<double> at_m;

  void visit(ConfigVisitor& v) { v.numbers("at_m", at_m, 2, 2, {-1000, 1000}, "m", "x, y"); }
};

/// Somebody who walks round and round.
struct PersonConfig {
  std::string name;
  double speed_mps = 0.8;
  double radius_m = 0.25;
  double height_m = 1.75;
  std::vector<WaypointConfig> waypoints;

  void visit(ConfigVisitor& v) {
    v.text("name", name, "who it is, for people");
    v.number("speed_mps", speed_mps, {0.05, 2}, "m/s", "how fast they walk");
    v.number("radius_m", radius_m, {0.15, 0.5}, "m", "of the circle on the floor that holds them");
    v.number("height_m", height_m, {0.5, 2.2}, "m", "how tall they are");
    v.list("waypoints", waypoints, "walked from one to the next, and from the last to the first");
  }
};

/// A world file (config/worlds/README.md).
struct WorldConfig {
  std::vector<double> lamp_m = {0, 0, 2.3};
  double ambient = 0.6;
  std::vector<Material> materials;
  StartConfig start;
  std::vector<BoxConfig> boxes;
  std::vector<WallConfig> walls;
  std::vector<PersonConfig> people;

  void visit(ConfigVisitor& v) {
    v.numbers("lamp_m", lamp_m, 3, 3, {-1000, 1000}, "m", "where the lamp hangs");
    v.number("ambient", ambient, {0, 1}, "", "share of the light that comes from everywhere");
    v.list("materials", materials, "what surfaces look like");
    v.group("start", start, "where the robot begins");
    v.list("boxes", boxes, "floor, furniture, ramps, whatever there is");
    v.list("walls", walls, "upright walls with openings: a shorter way to write boxes");
    v.list("people", people, "who may walk here; as many as a run asks for, the first ones first");
  }
};

}  // namespace cairn::simulation
