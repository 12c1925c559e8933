// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "core/time.hpp"
#include "planning/ground_view.hpp"
#include "stereo/disparity_image.hpp"

namespace cairn::planning {

/// What was seen of a spot of ground, and when; kNever where it was not.
struct GroundSpot {
  static constexpr Utime kNever = INT64_MIN / 2;
  Utime floor_utime = kNever;     ///< last seen to be floor
  Utime missed_utime = kNever;    ///< last looked at, or suspect, without seeing floor
  Utime obstacle_utime = kNever;  ///< last seen to be in the way, or a drop
  bool blocked = false;           ///< in the way, and not seen to be gone since
  Utime blocked_since = kNever;   ///< when what blocks was seen first
  float obstacle_ahead_m = 0;     ///< how far ahead of the body it was when it was seen last
  bool drop = false;              ///< what blocks is a drop
};

/// The ground round the robot, as lately seen, in a frame that stands still as far as the tracks
/// can tell: spots of 2.5 cm, 3.2 m to every side; what the robot leaves farther behind is
/// forgotten.
class GroundMemory {
 public:
  static constexpr double kSpot_m = 0.025;

  GroundMemory() : cells_(static_cast<std::size_t>(kSide) * kSide) {}

  void forget();

  /// Adds what one image showed of the ground, seen from `T_start_body`. A plain obstacle is there
  /// at once, others and drops when seen twice; it is gone when floor is seen in its place as often
  /// as it was seen (six times are enough), or what lies behind it is seen through it. What is
  /// hidden from one of the cameras by something that was seen, now or before, counts as not looked
  /// at.
  void add(const GroundView& view, const stereo::DisparityImage& image,
           const Eigen::Isometry2d& T_start_body);

  /// Something is in the way at a point of the standing frame, whatever was seen of it before; no
  /// camera saw it.
  void block(const Eigen::Vector2d& point_m, Utime utime);

  /// What is known of a point of the standing frame. Gaps of up to 12 cm in floor that was seen are
  /// floor, as of the older of its sides.
  [[nodiscard]] GroundSpot at(const Eigen::Vector2d& point_m) const;

 private:
  static constexpr int kSide = 256;  // a power of two
  static constexpr int kBlockedScore = 2;
  static constexpr int kMaxScore = 7;
  struct Cell {
    std::int32_t ix = INT32_MIN;
    std::int32_t iy = INT32_MIN;
    Utime floor_utime = GroundSpot::kNever;
    Utime missed_utime = GroundSpot::kNever;
    Utime obstacle_utime = GroundSpot::kNever;
    Utime blocked_since = GroundSpot::kNever;
    float top_m = 0;
    float obstacle_ahead_m = 0;
    std::int8_t score = 0;  ///< from kBlockedScore on: blocked
    bool drop = false;
  };

  struct Looked {
    Cell* cell;
    Eigen::Vector2d at_body_m;
  };

  [[nodiscard]] static std::int32_t spot_of(double metres);
  [[nodiscard]] const Cell* find(std::int32_t ix, std::int32_t iy) const;
  [[nodiscard]] Utime floor_on_both_sides(std::int32_t ix, std::int32_t iy) const;
  [[nodiscard]] Cell& take(std::int32_t ix, std::int32_t iy);
  void add_to(Cell& cell, const GroundCell& seen, double ahead_m, Utime utime);
  void look_through(Cell& cell, const Eigen::Vector2d& at_body_m,
                    const stereo::DisparityImage& image, const Isometry& T_camera_body);

  std::vector<Cell> cells_;
};

}  // namespace cairn::planning
