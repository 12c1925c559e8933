// SPDX-License-Identifier: Apache-2.0
#include "simulation/wall.hpp"

#include <cmath>

namespace cairn::simulation {
namespace {

/// An upright wall's own frame: x along it from its beginning, y across, z up from the floor.
struct WallFrame {
  Isometry T_world_wall = Isometry::Identity();
  double length_m = 0;
};

Result<WallFrame> frame_of(const WallConfig& wall, const std::string& key) {
  if (wall.from_m.empty()) return fail(key + "from_m: is missing");
  if (wall.to_m.empty()) return fail(key + "to_m: is missing");
  const double x_m = wall.to_m[0] - wall.from_m[0];
  const double y_m = wall.to_m[1] - wall.from_m[1];
  WallFrame frame;
  frame.length_m = std::hypot(x_m, y_m);
  if (frame.length_m < 0.01) return fail(key + "to_m: is less than 0.01 m from from_m");
  frame.T_world_wall.linear() = rotation_from_rpy(0, 0, std::atan2(y_m, x_m));
  frame.T_world_wall.translation() << wall.from_m[0], wall.from_m[1], 0;
  return frame;
}

}  // namespace

Result<std::vector<Box>> wall_pieces(const WallConfig& wall, const std::string& key) {
  const auto frame = frame_of(wall, key);
  if (!frame) return tl::make_unexpected(frame.error());
  std::vector<Box> pieces;
  const auto add = [&](double begin_m, double end_m, double low_m, double high_m) {
    Box piece;
    piece.name = wall.name;
    piece.half_size_m << 0.5 * (end_m - begin_m), 0.5 * wall.thickness_m, 0.5 * (high_m - low_m);
    piece.T_world_box = frame->T_world_wall;
    piece.T_world_box.translate(
        Eigen::Vector3d(0.5 * (begin_m + end_m), 0, 0.5 * (low_m + high_m)));
    pieces.push_back(std::move(piece));
  };
  const double beyond_m = kWallOverlap * wall.thickness_m;
  double begin_m = -beyond_m;
  for (std::size_t i = 0; i < wall.doors.size(); ++i) {
    const DoorConfig& door = wall.doors[i];
    const std::string door_key = key + "doors[" + std::to_string(i) + "].";
    const double left_m = door.at_m - 0.5 * door.width_m;
    const double right_m = door.at_m + 0.5 * door.width_m;
    if (left_m <= begin_m || right_m >= frame->length_m + beyond_m) {
      return fail(door_key +
                  "at_m: the opening does not fit between the one before and the wall's "
                  "end");
    }
    if (door.height_m >= wall.height_m) return fail(door_key + "height_m: is not below the wall's");
    add(begin_m, left_m, 0, wall.height_m);
    add(left_m, right_m, door.height_m, wall.height_m);
    begin_m = right_m;
  }
  add(begin_m, frame->length_m + beyond_m, 0, wall.height_m);
  return pieces;
}

}  // namespace cairn::simulation
