// SPDX-License-Identifier: Apache-2.0
#include "mapping/free_space.hpp"

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <random>
#include <set>
#include <string>

namespace cairn::mapping {
namespace {

constexpr double kVoxel_m = 0.02;
constexpr double kReach_m = 10;  ///< farther than anything here

enum class Answer { kFree, kNotFree, kTooCloseToCall };

/// FreeSpaceFinder's rule asked of one voxel, the plainest way: all pixels of its cell one by one.
class PlainRule {
 public:
  PlainRule(const RayGrid& rays, const Isometry& T_map_camera)
      : rays_{rays}, T_camera_map_{T_map_camera.inverse()} {}

  Answer ask(VoxelIndex voxel) const {
    const Eigen::Vector3d at = centre(voxel);
    const BrickIndex brick = brick_of(voxel);
    const Eigen::Vector3d first = centre(voxel_in(brick, 0));
    const Eigen::Vector3d last = centre(voxel_in(brick, kBrickVoxels - 1));
    double end_m = at.z();
    for (int axis = 0; axis < 3; ++axis)
      end_m += 0.5 * kVoxel_m * std::abs(T_camera_map_.linear()(2, axis));
    if (std::abs(at.z() - kVoxel_m) < kClose_m) return Answer::kTooCloseToCall;
    if (at.z() <= kVoxel_m) return Answer::kNotFree;
    const double brick_m = std::max(0.5 * (first.z() + last.z()), kVoxel_m);
    const double width_px = rays_.f_px * kVoxel_m / brick_m;
    const int longest = std::max(rays_.end_depth_m.rows, rays_.end_depth_m.cols);
    int cell_px = 1;
    while (2 * cell_px <= width_px && cell_px < longest) cell_px *= 2;
    const double u = rays_.f_px * at.x() / at.z() + rays_.cx_px + 0.5;
    const double v = rays_.f_px * at.y() / at.z() + rays_.cy_px + 0.5;
    if (near_border(u) || near_border(v)) return Answer::kTooCloseToCall;
    if (u < 0 || v < 0 || u >= rays_.end_depth_m.cols || v >= rays_.end_depth_m.rows)
      return Answer::kNotFree;
    const int row = static_cast<int>(v) / cell_px * cell_px;
    const int col = static_cast<int>(u) / cell_px * cell_px;
    double nearest_m = std::numeric_limits<double>::infinity();
    for (int r = row; r < row + cell_px; ++r) {
      for (int c = col; c < col + cell_px; ++c) {
        if (end(r, c) > 0) nearest_m = std::min(nearest_m, nearest_around(r, c));
      }
    }
    if (nearest_m == std::numeric_limits<double>::infinity()) return Answer::kNotFree;
    if (std::abs(end_m - nearest_m) < kClose_m) return Answer::kTooCloseToCall;
    return end_m < nearest_m ? Answer::kFree : Answer::kNotFree;
  }

 private:
  static constexpr double kClose_m = 1e-5;

  static bool near_border(double px) { return std::abs(px - std::round(px)) < 5e-4; }

  Eigen::Vector3d centre(VoxelIndex voxel) const {
    return T_camera_map_ *
           (kVoxel_m * Eigen::Vector3d(voxel.x + 0.5, voxel.y + 0.5, voxel.z + 0.5));
  }

  double end(int row, int col) const {
    if (row < 0 || col < 0 || row >= rays_.end_depth_m.rows || col >= rays_.end_depth_m.cols)
      return 0;
    return rays_.end_depth_m(row, col);
  }

  double nearest_around(int row, int col) const {
    double nearest_m = std::numeric_limits<double>::infinity();
    for (int r = row - 1; r <= row + 1; ++r) {
      for (int c = col - 1; c <= col + 1; ++c) {
        if (end(r, c) > 0) nearest_m = std::min(nearest_m, end(r, c));
      }
    }
    return nearest_m;
  }

  const RayGrid& rays_;
  Isometry T_camera_map_;
};

/// Something near, something far, a slope, holes of all sizes.
RayGrid made_rays(std::mt19937& random, int rows, int cols) {
  std::uniform_real_distribution<double> uniform(-1, 1);
  RayGrid rays;
  rays.f_px = 0.9 * cols;
  rays.cx_px = 0.5 * cols + 0.3 + 4 * uniform(random);
  rays.cy_px = 0.5 * rows - 0.2 + 4 * uniform(random);
  rays.end_depth_m.create(rows, cols);
  rays.is_hit = cv::Mat_<std::uint8_t>(rows, cols, std::uint8_t{1});
  const double slope = uniform(random) / cols;
  for (int row = 0; row < rows; ++row) {
    for (int col = 0; col < cols; ++col) {
      rays.end_depth_m(row, col) = 1.3 + 0.5 * slope * col + 0.004 * uniform(random);
    }
  }
  const auto rectangle = [&](int largest) {
    const int width = 1 + static_cast<int>(random() % static_cast<unsigned>(largest));
    const int height = 1 + static_cast<int>(random() % static_cast<unsigned>(largest));
    return cv::Rect(static_cast<int>(random() % static_cast<unsigned>(cols)),
                    static_cast<int>(random() % static_cast<unsigned>(rows)), width, height) &
           cv::Rect(0, 0, cols, rows);
  };
  for (int i = 0; i < 3; ++i) rays.end_depth_m(rectangle(rows / 4)) = 0.3 + 0.2 * i;
  for (int i = 0; i < 2; ++i) rays.end_depth_m(rectangle(rows / 5)) = 0;
  for (int i = 0; i < 20; ++i) rays.end_depth_m(rectangle(2)) = 0;
  return rays;
}

Isometry made_pose(std::mt19937& random) {
  std::uniform_real_distribution<double> uniform(-1, 1);
  Isometry T_map_camera = Isometry::Identity();
  const double roll = M_PI * uniform(random);
  const double pitch = 1.5 * uniform(random);
  T_map_camera.linear() = rotation_from_rpy(roll, pitch, M_PI * uniform(random));
  for (int axis = 0; axis < 3; ++axis) T_map_camera.translation()[axis] = 0.3 * uniform(random);
  return T_map_camera;
}

struct Frame {
  RayGrid rays;
  Isometry T_map_camera;
  FreeSpace free;
};

Frame made_frame(unsigned seed, int rows, int cols) {
  std::mt19937 random{seed};
  Frame frame{made_rays(random, rows, cols), made_pose(random), {}};
  DepthPyramid pyramid;
  pyramid.build(frame.rays);
  FreeSpaceFinder(frame.rays, pyramid, frame.T_map_camera, kVoxel_m, kReach_m).find(frame.free);
  return frame;
}

// Every voxel around the camera, before it and behind it, in view and out of it.
TEST(FreeSpaceFinder, SaysOfEveryVoxelWhatThePlainRuleSays) {
  std::size_t whole = 0;
  for (const unsigned seed : {1U, 2U, 3U, 4U, 5U, 6U}) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Frame frame = made_frame(seed, seed % 2 == 0 ? 90 : 121, seed % 3 == 0 ? 128 : 171);
    std::map<BrickIndex, VoxelMask> found;
    for (const BrickIndex brick : frame.free.whole) {
      EXPECT_TRUE(found.emplace(brick, VoxelMask::all()).second) << "twice";
    }
    for (const auto& [brick, voxels] : frame.free.parts) {
      EXPECT_TRUE(found.emplace(brick, voxels).second) << "twice";
    }
    const PlainRule rule(frame.rays, frame.T_map_camera);
    std::map<Answer, int> counts;
    constexpr int kReach = 80;
    for (int z = -kReach; z < kReach; ++z) {
      for (int y = -kReach; y < kReach; ++y) {
        for (int x = -kReach; x < kReach; ++x) {
          const VoxelIndex voxel{x, y, z};
          const Answer answer = rule.ask(voxel);
          ++counts[answer];
          if (answer == Answer::kTooCloseToCall) continue;
          const auto brick = found.find(brick_of(voxel));
          const bool free = brick != found.end() && brick->second.test(index_in_brick(voxel));
          ASSERT_EQ(free, answer == Answer::kFree) << x << " " << y << " " << z;
        }
      }
    }
    EXPECT_GT(counts[Answer::kFree], 20000);
    whole += frame.free.whole.size();
    EXPECT_LT(counts[Answer::kTooCloseToCall], 8 * kReach * kReach * kReach / 100);
  }
  EXPECT_GT(whole, 30u);
}

// Wide registers and the plain target that has none, bit for bit.
TEST(FreeSpaceFinder, IsTheSameOnEveryKindOfProcessor) {
  const Frame best = made_frame(7, 121, 171);
  const std::int64_t all = hwy::SupportedTargets();
  int targets = 0;
  for (std::int64_t left = all; left != 0; left &= left - 1) {
    hwy::SetSupportedTargetsForTest(left & ~(left - 1));
    const Frame same = made_frame(7, 121, 171);
    hwy::SetSupportedTargetsForTest(0);
    EXPECT_EQ(same.free.whole, best.free.whole);
    ASSERT_EQ(same.free.parts.size(), best.free.parts.size());
    for (std::size_t i = 0; i < best.free.parts.size(); ++i) {
      EXPECT_EQ(same.free.parts[i].index, best.free.parts[i].index);
      EXPECT_EQ(same.free.parts[i].free, best.free.parts[i].free);
    }
    ++targets;
  }
  EXPECT_GT(targets, 1) << "this processor has no wide registers to compare with";
  EXPECT_GT(best.free.parts.size(), 100u);
}

TEST(FreeSpaceFinder, WhereNothingIsAnsweredNothingIsFree) {
  Frame frame = made_frame(8, 48, 64);
  frame.rays.end_depth_m = 0.0;
  DepthPyramid pyramid;
  pyramid.build(frame.rays);
  FreeSpaceFinder(frame.rays, pyramid, frame.T_map_camera, kVoxel_m, kReach_m).find(frame.free);
  EXPECT_TRUE(frame.free.whole.empty());
  EXPECT_TRUE(frame.free.parts.empty());
}

}  // namespace
}  // namespace cairn::mapping
