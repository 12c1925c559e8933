// SPDX-License-Identifier: Apache-2.0
#include "planning/ground_view.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <numbers>

#include "stereo/depth_noise.hpp"

namespace cairn::planning {
namespace {

constexpr double kPatch_m = 0.025;
constexpr double kPatchShare = 0.35;
constexpr double kFloorShare = 0.1;
constexpr double kLeastAnswers = 3;
constexpr double kDisparitySigma_px = 0.3;
constexpr double kSigmas = 3;
constexpr double kTilt_rad = 0.01;  // of the camera, by calibration and by driving off
constexpr double kLookBack_m = 0.3;
constexpr std::size_t kSquaresBefore = 3;
constexpr double kJustBefore_m = 0.15;
constexpr int kLanesBeside = 3;
constexpr double kTall_m = 0.05;
constexpr double kNearFloorDepth_m = 0.35;
constexpr double kNearFloorHalfWidth_m = 0.3;
constexpr int kNearFloorCells = 12;
constexpr double kLeastRange_m = 0.1;
constexpr double kImageMargin_px = 8;
constexpr int kEnclosed = 5;        // of 8 neighbours
constexpr double kSureAnswers = 8;  // of so many that floor would give some always come

}  // namespace

GroundView::GroundView(const GroundConfig& config, const RobotConfig& robot)
    : config_{config},
      robot_{robot},
      slope_{std::tan(config.max_slope_deg * std::numbers::pi / 180)},
      top_m_{robot.height_m + config.headroom_m},
      columns_(static_cast<std::size_t>(kAhead) * kAcross),
      holes_(columns_.size()),
      cells_(columns_.size()),
      heights_m_(columns_.size()) {}

const GroundCell* GroundView::find(double x_m, double y_m) const {
  const int ahead = static_cast<int>(std::floor(x_m / kCell_m));
  const int across = static_cast<int>(std::floor(y_m / kCell_m)) + kAcross / 2;
  if (ahead < 0 || ahead >= kAhead || across < 0 || across >= kAcross) return nullptr;
  return &cell(ahead, across);
}

void GroundView::look(const stereo::DisparityImage& image) {
  std::memset(columns_.data(), 0, columns_.size() * sizeof(Column));
  std::fill(holes_.begin(), holes_.end(), std::uint16_t{0});
  std::fill(cells_.begin(), cells_.end(), GroundCell{});
  scale_ = image.camera.f_px / image.step_px;
  fb_px_m_ = image.camera.f_px * image.camera.baseline_m;
  eye_m_ = std::max(0.05, image.camera.T_body_camera.translation().z());
  collect(image);
  for (int across = kAcross / 2; across < kAcross; ++across) judge_lane(across, across - 1);
  for (int across = kAcross / 2 - 1; across >= 0; --across) judge_lane(across, across + 1);
  find_hidden_step();
  mark_drops();
  close_gaps();
  mark_looked_at(image);
}

void GroundView::collect(const stereo::DisparityImage& image) {
  const stereo::RectifiedCamera& camera = image.camera;
  const Eigen::Matrix3f R = camera.T_body_camera.linear().cast<float>();
  const Eigen::Vector3f eye = camera.T_body_camera.translation().cast<float>();
  const auto inverse_f = static_cast<float>(1 / camera.f_px);
  const auto fb_16ths = static_cast<float>(16 * fb_px_m_);
  const auto doffs_16ths = static_cast<float>(16 * camera.doffs_px);
  const auto reach_m = static_cast<float>(kAhead * kCell_m);
  const auto half_m = static_cast<float>(kAcross * kCell_m / 2);
  const auto slope = static_cast<float>(slope_);
  const auto step = static_cast<float>(config_.step_m);
  const auto sure_from_m = static_cast<float>(config_.view_from_m - kCell_m);
  for (int row = 0; row < image.rows(); ++row) {
    const float v =
        (static_cast<float>(row * image.step_px) - static_cast<float>(camera.cy_px)) * inverse_f;
    const std::uint16_t* disparity = image.disparity_16ths[row];
    const std::uint8_t* code = image.code[row];
    for (int col = 0; col < image.cols(); ++col) {
      const float d = static_cast<float>(disparity[col]) + doffs_16ths;
      if (disparity[col] == 0 || !(d > 0)) continue;
      const float depth_m = fb_16ths / d;
      if (!(depth_m < 2 * reach_m)) continue;
      const float u =
          (static_cast<float>(col * image.step_px) - static_cast<float>(camera.cx_px)) * inverse_f;
      const Eigen::Vector3f way = R * Eigen::Vector3f(u * depth_m, v * depth_m, depth_m);
      const Eigen::Vector3f p = eye + way;
      if (p.z() > static_cast<float>(top_m_)) continue;
      if (p.z() < -step - slope * p.x()) {
        const float share = eye.z() / -way.z();
        const float x = eye.x() + share * way.x();
        const float y = eye.y() + share * way.y();
        // There floor is too near for a matcher, and what it answers is made up.
        if (x < sure_from_m) continue;
        if (code[col] > 0 && x < reach_m && std::abs(y) < half_m) {
          ++holes_[index(static_cast<int>(x / static_cast<float>(kCell_m)),
                         static_cast<int>((y + half_m) / static_cast<float>(kCell_m)))];
        }
      }
      if (!(p.x() > static_cast<float>(kLeastRange_m) && p.x() < reach_m &&
            std::abs(p.y()) < half_m)) {
        continue;
      }
      Column& column =
          columns_[index(static_cast<int>(p.x() / static_cast<float>(kCell_m)),
                         static_cast<int>((p.y() + half_m) / static_cast<float>(kCell_m)))];
      const auto height_bins = (p.z() - static_cast<float>(kBottom_m)) / static_cast<float>(kBin_m);
      const int bin = std::clamp(static_cast<int>(std::floor(height_bins)) + 1, 0, kBins - 1);
      ++column.answers[bin];
      if (code[col] > 0) ++column.sure[bin];
      column.top_m = std::max(column.top_m, p.z());
    }
  }
}

double GroundView::noise_m(double range_m) const {
  const double sigma_m = stereo::depth_sigma_m(1, fb_px_m_, range_m, kDisparitySigma_px);
  return kSigmas * sigma_m * eye_m_ / range_m;
}

void GroundView::judge_lane(int across, int beside) {
  std::vector<Reference> floor{{robot_.length_m / 2, 0}};
  for (int ahead = 0; ahead < kAhead; ++ahead) judge_cell(ahead, across, beside, floor);
}

// As high and as low as floor may be by the floor just before and beside it, by more than one
// square of it, for a matcher may err about a patch.
GroundView::Bounds GroundView::bounds_by_floor_near(int ahead, int across, int beside,
                                                    double step_m,
                                                    const std::vector<Reference>& floor) const {
  constexpr double kNone = std::numeric_limits<double>::infinity();
  Bounds bounds{kNone, -kNone};
  const auto allow = [&](const Reference& from) {
    const double reach_m = step_m + slope_ * std::max(kCell_m, x_m(ahead) - from.x_m);
    bounds.low_m = std::min(bounds.low_m, from.height_m - reach_m);
    bounds.high_m = std::max(bounds.high_m, from.height_m + reach_m);
  };
  for (std::size_t i = 0; i < std::min(floor.size(), kSquaresBefore); ++i) {
    const Reference& before = floor[floor.size() - 1 - i];
    if (i == 0 || before.x_m > floor.back().x_m - kJustBefore_m) allow(before);
  }
  const int away = beside - across;
  for (int lane = 1; lane <= kLanesBeside; ++lane) {
    const int y = across + lane * away;
    if (y < 0 || y >= kAcross) break;
    for (int x = std::max(0, ahead - kLanesBeside); x <= ahead; ++x) {
      if (cell(x, y).ground == Ground::kFloor)
        allow({x_m(x), static_cast<double>(heights_m_[index(x, y)])});
    }
  }
  return bounds;
}

void GroundView::judge_cell(int ahead, int across, int beside, std::vector<Reference>& floor) {
  const std::size_t at = index(ahead, across);
  const Column& column = columns_[at];
  const double x = x_m(ahead);
  const double range_m = std::hypot(x, y_m(across));
  const double per_m = scale_ / range_m;
  const double patch = std::pow(per_m * kPatch_m, 2);
  const double obstacle_answers = std::max(kLeastAnswers, kPatchShare * patch);
  const double floor_answers =
      std::max(1.0, kFloorShare * std::pow(per_m * kCell_m, 2) * eye_m_ / range_m);

  // As high and as low as floor may be here: by the floor that the robot stands on, by the floor
  // just before, and by the floor a while before.
  const double step_m = config_.step_m + noise_m(range_m);
  const double level_m = step_m + kTilt_rad * x;  // as high is what the robot stands on
  double high_m = level_m + slope_ * std::max(0.0, x - robot_.length_m / 2);
  double low_m = -high_m;
  const Bounds near = bounds_by_floor_near(ahead, across, beside, step_m, floor);
  high_m = std::min(high_m, near.high_m);
  low_m = std::max(low_m, near.low_m);
  const auto back = std::find_if(floor.rbegin(), floor.rend(), [&](const Reference& reference) {
    return reference.x_m <= x - kLookBack_m;
  });
  if (back != floor.rend()) {
    const double reach_m = step_m + slope_ * (x - back->x_m);
    high_m = std::min(high_m, back->height_m + reach_m);
    low_m = std::max(low_m, back->height_m - reach_m);
  }

  const auto bin_of = [](double height_m) {
    return std::clamp(static_cast<int>(std::floor((height_m - kBottom_m) / kBin_m)) + 1, 0,
                      kBins - 1);
  };
  const int low_bin = bin_of(low_m);
  const int high_bin = bin_of(high_m);
  const int level_bin = bin_of(level_m);
  double below = 0;
  double level = 0;
  double unsure_level = 0;
  double above = 0;
  double height_sum_m = 0;
  for (int bin = 0; bin < kBins; ++bin) {
    const double sure = column.sure[bin];
    if (bin < low_bin) {
      below += sure;
    } else if (bin > high_bin) {
      if (bin > level_bin) above += column.answers[bin];
    } else {
      level += sure;
      unsure_level += column.answers[bin] - sure;
      height_sum_m += sure * (kBottom_m + (bin - 0.5) * kBin_m);
    }
  }
  GroundCell& cell = cells_[at];
  if (above >= obstacle_answers) {
    cell.ground = Ground::kObstacle;
    cell.plain =
        above >= 2 * obstacle_answers && static_cast<double>(column.top_m) > high_m + kTall_m;
    cell.top_m = column.top_m;
  } else if (below >= obstacle_answers && below > level + unsure_level) {
    cell.ground = Ground::kDrop;
  } else if (level >= floor_answers) {
    cell.ground = Ground::kFloor;
    const double height_m = height_sum_m / level;
    heights_m_[at] = static_cast<float>(height_m);
    floor.push_back({x, height_m});
  }
}

// A ray that ends below the floor's level went through it: there the floor ends.
void GroundView::mark_drops() {
  for (std::size_t i = 0; i < cells_.size(); ++i) {
    const int ahead = static_cast<int>(i % kAhead);
    const double per_m = scale_ / std::max(kLeastRange_m, x_m(ahead));
    const double enough = std::max(kLeastAnswers, kPatchShare * std::pow(per_m * kPatch_m, 2));
    if (holes_[i] >= enough && cells_[i].ground == Ground::kUnseen)
      cells_[i].ground = Ground::kDrop;
  }
}

void GroundView::find_hidden_step() {
  const int half = static_cast<int>(kNearFloorHalfWidth_m / kCell_m);
  int first = kAhead;
  for (int across = kAcross / 2 - half; across < kAcross / 2 + half; ++across) {
    for (int ahead = 0; ahead < first; ++ahead) {
      if (cell(ahead, across).ground == Ground::kFloor) first = ahead;
    }
  }
  const int last = std::min(kAhead, first + static_cast<int>(kNearFloorDepth_m / kCell_m));
  Eigen::Matrix3d A = Eigen::Matrix3d::Zero();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
  int count = 0;
  for (int across = kAcross / 2 - half; across < kAcross / 2 + half; ++across) {
    for (int ahead = first; ahead < last; ++ahead) {
      if (cell(ahead, across).ground != Ground::kFloor) continue;
      const Eigen::Vector3d row(1, x_m(ahead), y_m(across));
      A += row * row.transpose();
      b += row * static_cast<double>(heights_m_[index(ahead, across)]);
      ++count;
    }
  }
  if (count < kNearFloorCells) return;
  const Eigen::Vector3d plane = A.ldlt().solve(b);
  if (!plane.allFinite()) return;
  const double front_m = robot_.length_m / 2;
  const double at_robot_m = plane[0] + plane[1] * front_m;
  // A ramp that begins between the robot and there, carried on to the robot, misses the floor by
  // its slope times that way.
  const double ramp_m = std::abs(plane[1]) * std::max(0.0, x_m(first) - front_m);
  const double highest_m = config_.step_m + (plane[1] < 0 ? ramp_m : 0);
  const double lowest_m = -config_.step_m - (plane[1] > 0 ? ramp_m : 0);
  if (at_robot_m <= highest_m && at_robot_m >= lowest_m) return;
  const Ground step = at_robot_m > 0 ? Ground::kObstacle : Ground::kDrop;
  for (int across = kAcross / 2 - half; across < kAcross / 2 + half; ++across) {
    for (int ahead = 0; ahead < first; ++ahead) {
      cells_[index(ahead, across)].suspect = cell(ahead, across).ground == Ground::kUnseen;
    }
    for (int ahead = first; ahead < last; ++ahead) {
      GroundCell& near = cells_[index(ahead, across)];
      if (near.ground != Ground::kFloor) continue;
      near.ground = step;
      near.plain = true;
      near.top_m = heights_m_[index(ahead, across)];
    }
  }
}

// Two squares in a row without an answer between floor before and behind, or a single one amid
// floor, are floor: what stands up by a step hides more floor than that behind it.
void GroundView::close_gaps() {
  std::vector<std::size_t> gaps;
  const auto is_floor = [&](int ahead, int across) {
    return cell(ahead, across).ground == Ground::kFloor;
  };
  for (int across = 1; across + 1 < kAcross; ++across) {
    for (int ahead = 1; ahead + 2 < kAhead; ++ahead) {
      if (cell(ahead, across).ground != Ground::kUnseen) continue;
      int floor = 0;
      for (int dy = -1; dy <= 1; ++dy) {
        for (int dx = -1; dx <= 1; ++dx) floor += is_floor(ahead + dx, across + dy) ? 1 : 0;
      }
      const bool two = cell(ahead + 1, across).ground == Ground::kUnseen;
      const bool between =
          is_floor(ahead - 1, across) && is_floor(two ? ahead + 2 : ahead + 1, across);
      if (floor >= kEnclosed || between) gaps.push_back(index(ahead, across));
      if (between && two) gaps.push_back(index(ahead + 1, across));
    }
  }
  for (const std::size_t gap : gaps) cells_[gap].ground = Ground::kFloor;
}

bool GroundView::has_floor_beside(int ahead, int across) const {
  constexpr int kReach = 2;
  for (int y = std::max(0, across - kReach); y <= std::min(kAcross - 1, across + kReach); ++y) {
    for (int x = std::max(0, ahead - kReach); x <= std::min(kAhead - 1, ahead + kReach); ++x) {
      if (cell(x, y).ground == Ground::kFloor) return true;
    }
  }
  return false;
}

// Patches of floor up to some 10 cm wide get no answer, or none that is sure; where floor is seen
// right beside, an unseen square tells nothing. What stands there hides more than that.
void GroundView::mark_looked_at(const stereo::DisparityImage& image) {
  const stereo::RectifiedCamera& camera = image.camera;
  const Isometry T_camera_body = camera.T_body_camera.inverse();
  for (int across = 0; across < kAcross; ++across) {
    for (int ahead = 0; ahead < kAhead; ++ahead) {
      if (x_m(ahead) < config_.view_from_m || has_floor_beside(ahead, across)) continue;
      const double per_m = scale_ / x_m(ahead);
      if (std::pow(per_m * kCell_m, 2) * eye_m_ / x_m(ahead) < kSureAnswers) continue;
      const Eigen::Vector3d p = T_camera_body * Eigen::Vector3d(x_m(ahead), y_m(across), 0);
      if (!(p.z() > kLeastRange_m)) continue;
      const double u = camera.cx_px + camera.f_px * p.x() / p.z();
      const double v = camera.cy_px + camera.f_px * p.y() / p.z();
      const double in_right_u = u - (fb_px_m_ / p.z() - camera.doffs_px);
      cells_[index(ahead, across)].looked_at =
          in_right_u >= kImageMargin_px && u <= camera.width_px - kImageMargin_px &&
          v >= kImageMargin_px && v <= camera.height_px - kImageMargin_px;
    }
  }
}

}  // namespace cairn::planning
