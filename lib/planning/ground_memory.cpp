// SPDX-License-Identifier: Apache-2.0
#include "planning/ground_memory.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "planning/shadows.hpp"

namespace cairn::planning {
namespace {

constexpr std::array<double, 5> kLookHeights_m{0.05, 0.1, 0.2, 0.3, 0.4};
constexpr double kBehindShare = 1.15;  // of an obstacle's depth: what is deeper lies behind it
constexpr double kBehind_m = 0.1;
// A thin thing may stand this far beside where it is remembered.
constexpr std::array<double, 3> kLookAside_m{-0.05, 0, 0.05};
constexpr int kLooksThrough = 4;
// One look in so many; what stands too near for the matcher has no answers, and may be thin.
constexpr int kMostUnanswered = 3;
constexpr int kThroughScore = 2;
constexpr double kMinDepth_m = 0.2;

}  // namespace

void GroundMemory::forget() { std::fill(cells_.begin(), cells_.end(), Cell{}); }

std::int32_t GroundMemory::spot_of(double metres) {
  return static_cast<std::int32_t>(std::floor(metres / kSpot_m));
}

GroundMemory::Cell& GroundMemory::take(std::int32_t ix, std::int32_t iy) {
  const auto wrapped = [](std::int32_t i) { return static_cast<std::size_t>(i & (kSide - 1)); };
  Cell& cell = cells_[wrapped(iy) * kSide + wrapped(ix)];
  if (cell.ix != ix || cell.iy != iy) {
    cell = Cell{};
    cell.ix = ix;
    cell.iy = iy;
  }
  return cell;
}

const GroundMemory::Cell* GroundMemory::find(std::int32_t ix, std::int32_t iy) const {
  const auto wrapped = [](std::int32_t i) { return static_cast<std::size_t>(i & (kSide - 1)); };
  const Cell& cell = cells_[wrapped(iy) * kSide + wrapped(ix)];
  return cell.ix == ix && cell.iy == iy ? &cell : nullptr;
}

GroundSpot GroundMemory::at(const Eigen::Vector2d& point_m) const {
  const std::int32_t ix = spot_of(point_m.x());
  const std::int32_t iy = spot_of(point_m.y());
  GroundSpot spot;
  if (const Cell* cell = find(ix, iy)) {
    spot = {cell->floor_utime,
            cell->missed_utime,
            cell->obstacle_utime,
            cell->score >= kBlockedScore,
            cell->blocked_since,
            cell->obstacle_ahead_m,
            cell->drop};
  }
  if (spot.floor_utime == GroundSpot::kNever && !spot.blocked)
    spot.floor_utime = floor_on_both_sides(ix, iy);
  return spot;
}

Utime GroundMemory::floor_on_both_sides(std::int32_t ix, std::int32_t iy) const {
  const auto nearest = [&](std::int32_t dx, std::int32_t dy, int most) {
    for (int i = 1; i <= most; ++i) {
      const Cell* cell = find(ix + i * dx, iy + i * dy);
      if (cell == nullptr) continue;
      if (cell->score >= kBlockedScore) break;
      if (cell->floor_utime != GroundSpot::kNever) return std::pair{i, cell->floor_utime};
    }
    return std::pair{most, GroundSpot::kNever};
  };
  Utime best = GroundSpot::kNever;
  for (const auto& [dx, dy, gap] : {std::array{1, 0, 5}, {0, 1, 5}, {1, 1, 3}, {1, -1, 3}}) {
    const auto [steps, there] = nearest(dx, dy, gap);
    if (there == GroundSpot::kNever) continue;
    best = std::max(best, std::min(there, nearest(-dx, -dy, gap + 1 - steps).second));
  }
  return best;
}

void GroundMemory::block(const Eigen::Vector2d& point_m, Utime utime) {
  Cell& cell = take(spot_of(point_m.x()), spot_of(point_m.y()));
  cell.obstacle_utime = utime;
  cell.obstacle_ahead_m = 0;
  cell.blocked_since = utime;
  cell.score = kBlockedScore;
  cell.drop = false;
  cell.top_m = 0;
}

void GroundMemory::add(const GroundView& view, const stereo::DisparityImage& image,
                       const Eigen::Isometry2d& T_start_body) {
  const Isometry T_camera_body = image.camera.T_body_camera.inverse();
  const Eigen::Isometry2d T_body_start = T_start_body.inverse();
  // The box of spots that holds the view, whatever way it is turned.
  const double ahead_m = GroundView::kAhead * GroundView::kCell_m;
  const double half_m = GroundView::kAcross * GroundView::kCell_m / 2;
  Eigen::AlignedBox2d box;
  for (const double x : {0.0, ahead_m}) {
    for (const double y : {-half_m, half_m}) box.extend(T_start_body * Eigen::Vector2d(x, y));
  }
  std::vector<Looked> in_vain;
  std::vector<Eigen::Vector2d> things_m;
  for (std::int32_t iy = spot_of(box.min().y()); iy <= spot_of(box.max().y()); ++iy) {
    for (std::int32_t ix = spot_of(box.min().x()); ix <= spot_of(box.max().x()); ++ix) {
      const Eigen::Vector2d p =
          T_body_start * Eigen::Vector2d((ix + 0.5) * kSpot_m, (iy + 0.5) * kSpot_m);
      const GroundCell* seen = view.find(p.x(), p.y());
      if (seen == nullptr) continue;
      Cell& cell = take(ix, iy);
      add_to(cell, *seen, p.x(), image.utime);
      if (cell.score > 0 && cell.obstacle_utime != image.utime)
        look_through(cell, p, image, T_camera_body);
      if (!cell.drop && (cell.score >= kBlockedScore || seen->ground == Ground::kObstacle))
        things_m.push_back(p);
      if (seen->ground == Ground::kUnseen && seen->looked_at) in_vain.push_back({&cell, p});
    }
  }
  if (in_vain.empty()) return;
  std::vector<Shadows> shadows;
  for (const double right_m : {0.0, image.camera.baseline_m}) {
    const Eigen::Vector3d eye = image.camera.T_body_camera * Eigen::Vector3d(right_m, 0, 0);
    Shadows& shadow = shadows.emplace_back(eye.head<2>());
    for (const Eigen::Vector2d& thing_m : things_m) shadow.add(thing_m, kSpot_m);
  }
  for (const Looked& looked : in_vain) {
    if (!shadows[0].hide(looked.at_body_m) && !shadows[1].hide(looked.at_body_m))
      looked.cell->missed_utime = image.utime;
  }
}

void GroundMemory::add_to(Cell& cell, const GroundCell& seen, double ahead_m, Utime utime) {
  switch (seen.ground) {
    case Ground::kUnseen:
      if (seen.suspect && cell.floor_utime == GroundSpot::kNever) cell.missed_utime = utime;
      break;
    case Ground::kFloor:
      cell.floor_utime = utime;
      if (cell.score > 0) --cell.score;
      break;
    case Ground::kObstacle:
    case Ground::kDrop:
      if (cell.score <= 0) {
        cell.top_m = 0;
        cell.blocked_since = utime;
      }
      cell.obstacle_utime = utime;
      cell.obstacle_ahead_m = static_cast<float>(ahead_m);
      cell.drop = seen.ground == Ground::kDrop;
      cell.top_m = std::max(cell.top_m, seen.top_m);
      cell.score = static_cast<std::int8_t>(std::min(kMaxScore, cell.score + (seen.plain ? 2 : 1)));
      if (cell.score >= kBlockedScore) cell.missed_utime = utime;
      break;
  }
}

void GroundMemory::look_through(Cell& cell, const Eigen::Vector2d& at_body_m,
                                const stereo::DisparityImage& image,
                                const Isometry& T_camera_body) {
  if (cell.drop) return;
  const stereo::RectifiedCamera& camera = image.camera;
  int through = 0;
  int unanswered = 0;
  for (const double height_m : kLookHeights_m) {
    if (height_m > static_cast<double>(cell.top_m)) break;
    for (const double aside_m : kLookAside_m) {
      const Eigen::Vector3d p =
          T_camera_body * Eigen::Vector3d(at_body_m.x(), at_body_m.y() + aside_m, height_m);
      if (p.z() < kMinDepth_m) return;
      const int col = static_cast<int>(
          std::lround((camera.cx_px + camera.f_px * p.x() / p.z()) / image.step_px));
      const int row = static_cast<int>(
          std::lround((camera.cy_px + camera.f_px * p.y() / p.z()) / image.step_px));
      if (col < 0 || col >= image.cols() || row < 0 || row >= image.rows()) continue;
      if (!image.valid(row, col)) {
        ++unanswered;
        continue;
      }
      if (image.depth_m(row, col) < kBehindShare * p.z() + kBehind_m) return;
      ++through;
    }
  }
  if (through < kLooksThrough || kMostUnanswered * unanswered > through) return;
  cell.score = static_cast<std::int8_t>(std::max(0, cell.score - kThroughScore));
  // What hid the floor is gone; what was seen of it before holds again.
  if (cell.score < kBlockedScore) cell.missed_utime = GroundSpot::kNever;
}

}  // namespace cairn::planning
