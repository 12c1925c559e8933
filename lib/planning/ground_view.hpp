// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "core/config.hpp"
#include "core/robot.hpp"
#include "stereo/disparity_image.hpp"

namespace cairn::planning {

/// What counts as floor.
struct GroundConfig {
  double step_m = 0.03;
  double max_slope_deg = 6.5;
  double headroom_m = 0.05;
  double view_from_m = 0.80;

  void visit(ConfigVisitor& v) {
    v.number("step_m", step_m, {0.005, 0.5}, "m",
             "what stands up or goes down by more, beyond slope and noise, is no floor");
    v.number("max_slope_deg", max_slope_deg, {0, 30}, "deg", "steeper is no floor");
    v.number("headroom_m", headroom_m, {0, 1}, "m",
             "over the robot's height: what hangs higher is driven under");
    v.number("view_from_m", view_from_m, {0.1, 5}, "m",
             "from the body's origin: floor that lies ahead nearer than this may be out of the "
             "cameras' sight");
  }
};

enum class Ground : std::uint8_t {
  kUnseen,    ///< nothing that stereo answered lies there
  kFloor,     ///< seen, and the robot can stand on it
  kObstacle,  ///< something rises from it, or hangs too low
  kDrop,      ///< seen below where the floor would be
};

struct GroundCell {
  Ground ground = Ground::kUnseen;
  bool looked_at =
      false;             ///< no floor there or beside, though cameras would see one if it was bare
  bool suspect = false;  ///< out of sight, and a step lies somewhere between here and what is seen
  bool plain = false;    ///< an obstacle of some height, seen by twice the answers that make one
  float top_m = 0;       ///< of an obstacle: how high it was seen, at most
};

/// One disparity image as squares of ground before the robot: body frame, x forward from 0, y left.
class GroundView {
 public:
  static constexpr double kCell_m = 0.04;
  static constexpr int kAhead = 75;   ///< cells along x: 3 m
  static constexpr int kAcross = 60;  ///< cells along y: 1.2 m to either side

  GroundView(const GroundConfig& config, const RobotConfig& robot);

  /// Judges every square. Lane by lane, from the robot outwards, a square is floor where what was
  /// seen there goes on from the floor before it by at most the slope and a step; so a ramp is
  /// floor, and a kerb of the same height is not. Where the nearest floor that is seen, carried on
  /// down to the robot by its own slope, misses the floor that the robot stands on by over a step,
  /// it is a step that lies out of sight: the ground between is suspect. What is no floor and
  /// no higher than what the robot stands on is nothing. An obstacle takes as many answers as a
  /// third of a patch of 2.5 cm gives at its distance, of whatever confidence; floor and drops take
  /// confident ones.
  void look(const stereo::DisparityImage& image);

  [[nodiscard]] const GroundCell& cell(int ahead, int across) const {
    return cells_[index(ahead, across)];
  }
  /// The square of a point; null outside.
  [[nodiscard]] const GroundCell* find(double x_m, double y_m) const;

  /// Middle of a square.
  [[nodiscard]] static double x_m(int ahead) { return (ahead + 0.5) * kCell_m; }
  [[nodiscard]] static double y_m(int across) { return (across + 0.5 - kAcross / 2) * kCell_m; }

 private:
  /// Heights in a square: one bin below kBottom_m, then centimetres, then one for all that is
  /// higher, up to the robot's top.
  static constexpr double kBottom_m = -0.30;
  static constexpr double kBin_m = 0.01;
  static constexpr int kBins = 48;
  struct Column {
    std::uint16_t answers[kBins];  ///< with any confidence
    std::uint16_t sure[kBins];     ///< of these, those with confidence 1 or more
    float top_m;
  };
  struct Reference {
    double x_m;
    double height_m;
  };

  [[nodiscard]] static std::size_t index(int ahead, int across) {
    return static_cast<std::size_t>(across) * kAhead + static_cast<std::size_t>(ahead);
  }
  void collect(const stereo::DisparityImage& image);
  struct Bounds {
    double low_m;
    double high_m;
  };
  void judge_lane(int across, int beside);
  void judge_cell(int ahead, int across, int beside, std::vector<Reference>& floor);
  [[nodiscard]] Bounds bounds_by_floor_near(int ahead, int across, int beside, double step_m,
                                            const std::vector<Reference>& floor) const;
  [[nodiscard]] double noise_m(double range_m) const;
  void mark_drops();
  void find_hidden_step();
  void close_gaps();
  [[nodiscard]] bool has_floor_beside(int ahead, int across) const;
  void mark_looked_at(const stereo::DisparityImage& image);

  GroundConfig config_;
  RobotConfig robot_;
  double slope_;
  double top_m_;
  double scale_ = 0;  ///< answers per radian
  double fb_px_m_ = 1;
  double eye_m_ = 0;  ///< the camera's height
  std::vector<Column> columns_;
  std::vector<std::uint16_t> holes_;  ///< rays that go through the floor's level there
  std::vector<GroundCell> cells_;
  std::vector<float> heights_m_;  ///< of floor
};

}  // namespace cairn::planning
