// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cstring>
#include <functional>
#include <limits>
#include <string>

#include "mapping/export_ply.hpp"
#include "mapping/top_down.hpp"

namespace cairn::mapping {
namespace {

/// Occupies the voxels [low, high) and frees those of the 8 m square around them at z = 0.
VoxelMap room_with_block(VoxelIndex low, VoxelIndex high) {
  VoxelMap map{0.1};
  for (int x = -40; x < 40; ++x) {
    for (int y = -40; y < 40; ++y) {
      VoxelMask one;
      one.set(index_in_brick({x, y, 0}));
      map.add_evidence(brick_of({x, y, 0}), {}, one, 1, 20);
    }
  }
  for (int x = low.x; x < high.x; ++x) {
    for (int y = low.y; y < high.y; ++y) {
      for (int z = low.z; z < high.z; ++z) {
        VoxelMask one;
        one.set(index_in_brick({x, y, z}));
        map.add_evidence(brick_of({x, y, z}), one, {}, 255, 1);
      }
    }
  }
  return map;
}

std::size_t pixels_of(const cv::Mat& picture, const std::function<bool(cv::Vec3b)>& is) {
  std::size_t count = 0;
  for (const cv::Vec3b& pixel : cv::Mat_<cv::Vec3b>(picture)) count += is(pixel) ? 1 : 0;
  return count;
}

bool is_greenish(cv::Vec3b bgr) { return bgr[1] > bgr[0] + 60 && bgr[1] > bgr[2] + 60; }
bool is_reddish(cv::Vec3b bgr) { return bgr[2] > bgr[0] + 60; }
bool is_blueish(cv::Vec3b bgr) { return bgr[0] > bgr[1] + 60 && bgr[0] > bgr[2] + 60; }

TEST(TopDown, AnEmptyMapIsAPictureWithoutContent) {
  const cv::Mat picture = render_top_down(VoxelMap{0.01});
  EXPECT_EQ(picture.type(), CV_8UC3);
  EXPECT_LE(std::max(picture.rows, picture.cols), 1100);
}

TEST(TopDown, TheLongerSideIsAboutTheSizeAskedForWhateverTheResolution) {
  for (const int size_px : {300, 1000}) {
    for (const std::int32_t length : {30, 900, 20000}) {
      VoxelMap map{0.02};
      VoxelMask all;
      all.words.fill(~std::uint64_t{0});
      map.add_evidence({0, 0, 0}, all, {}, 20, 1);
      map.add_evidence(brick_of({length, 40, 0}), all, {}, 20, 1);
      TopDownConfig config;
      config.size_px = size_px;
      const cv::Mat picture = render_top_down(map, {}, config);
      EXPECT_LE(picture.cols, size_px + size_px / 20) << length;
      EXPECT_GE(picture.cols, size_px / 2) << length;
    }
  }
}

TEST(TopDown, OccupiedIsColouredWhereItIsAndFreeIsLight) {
  // A block 2 m by 1 m in the middle of the picture's upper right quarter.
  const VoxelMap map = room_with_block({10, 10, 0}, {30, 20, 10});
  TopDownOverlay overlay;
  overlay.true_path = {{-3.9, -3.9, 0}, {-3.9, -3.8, 0}};
  const cv::Mat picture = render_top_down(map, overlay);
  // Bounding box: path and block, x from -3.9 to 3.0 m, y from -3.9 to 2.0 m, and a margin of 4 %.
  const double margin_m = 0.04 * 6.9;
  const double px_per_m = picture.cols / (6.9 + 2 * margin_m);
  const auto at = [&](double x_m, double y_m) {
    const int col = static_cast<int>((x_m + 3.9 + margin_m) * px_per_m);
    const int row = static_cast<int>((2.0 + margin_m - y_m) * px_per_m);
    return cv::mean(cv::Mat{picture}(cv::Rect{col - 3, row - 3, 7, 7}));
  };
  const cv::Scalar block = at(2, 1.5);
  const cv::Scalar floor = at(0, 0);
  EXPECT_GT(block[2] - block[0], 100);  // the ramp runs from violet to amber
  EXPECT_GT(floor[0] + floor[1] + floor[2], 740);
}

TEST(TopDown, FlatGroundIsPaleUnderWhatStandsOnIt) {
  VoxelMap map = room_with_block({-40, -40, 0}, {40, 40, 1});
  const cv::Mat flat = render_top_down(map);
  VoxelMask all;
  all.words.fill(~std::uint64_t{0});
  map.add_evidence(brick_of({0, 0, 0}), all, {}, 255, 1);
  const cv::Mat picture = render_top_down(map);
  const cv::Vec3b ground = picture.at<cv::Vec3b>(picture.cols / 8, picture.cols / 8);
  EXPECT_GT(ground[0] + ground[1] + ground[2], 650);
  const cv::Vec3b block = picture.at<cv::Vec3b>(picture.cols / 2 - 10, picture.cols / 2 + 10);
  EXPECT_GT(block[2] - block[0], 100);
  EXPECT_LT(flat.at<cv::Vec3b>(flat.cols / 8, flat.cols / 8)[0], 200)
      << "where all there is is flat, it is no ground but what was mapped";
}

TEST(TopDown, UnknownIsGrey) {
  VoxelMap map{0.1};
  VoxelMask one;
  one.set(0);
  map.add_evidence({0, 0, 0}, one, {}, 20, 1);
  map.add_evidence({10, 10, 0}, one, {}, 20, 1);
  const cv::Vec3b corner = render_top_down(map).at<cv::Vec3b>(3, 3);
  EXPECT_NEAR(corner[0], 200, 20);
  EXPECT_NEAR(corner[1], corner[0], 10);
  EXPECT_NEAR(corner[2], corner[0], 10);
}

TEST(TopDown, PathsAndPoseAreDrawnInTheirColours) {
  const VoxelMap map = room_with_block({10, 10, 0}, {20, 20, 5});
  const cv::Mat bare = render_top_down(map);
  EXPECT_EQ(pixels_of(bare, is_greenish), 0u);
  EXPECT_EQ(pixels_of(bare, is_blueish), 0u);
  TopDownOverlay overlay;
  overlay.true_path = {{0, 0, 0}, {1, 0, 0}};
  EXPECT_GT(pixels_of(render_top_down(map, overlay), is_greenish), 200u);
  overlay.true_path.clear();
  overlay.perceived_path = {{0, 0, 0}, {1, 0, 0}};
  EXPECT_GT(pixels_of(render_top_down(map, overlay), is_blueish), 100u);
  overlay.perceived_path.clear();
  overlay.T_map_body = Isometry::Identity();
  EXPECT_GT(pixels_of(render_top_down(map, overlay), is_blueish), 80u);
  overlay.T_map_true_body = Isometry::Identity();
  EXPECT_GT(pixels_of(render_top_down(map, overlay), is_blueish), 80u);
  EXPECT_GT(pixels_of(render_top_down(map, overlay), is_greenish), 80u)
      << "the true one is larger, so that both show where they are one";
}

TEST(TopDown, TheHeightBandLeavesOutWhatIsAbove) {
  const VoxelMap map = room_with_block({10, 10, 20}, {20, 20, 25});
  TopDownConfig below;
  below.max_height_m = 1;
  const std::size_t of_legend = pixels_of(render_top_down(VoxelMap{0.1}), is_reddish);
  EXPECT_GT(pixels_of(render_top_down(map), is_reddish), of_legend + 5000u);
  EXPECT_EQ(pixels_of(render_top_down(map, {}, below), is_reddish), of_legend);
}

TEST(TopDown, OverlaysThatAreNotFiniteOrFarOffDoNoHarm) {
  const VoxelMap map = room_with_block({10, 10, 0}, {20, 20, 5});
  TopDownOverlay overlay;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  overlay.true_path = {{nan, 0, 0}, {0, 0, 0}, {1e30, 0, 0}};
  overlay.perceived_path = {{nan, nan, nan}};
  overlay.T_map_body = Isometry::Identity();
  overlay.T_map_body->translation().x() = nan;
  const cv::Mat picture = render_top_down(map, overlay);
  EXPECT_LE(std::max(picture.rows, picture.cols), 1100);
}

TEST(Ply, HoldsTheCentreOfEveryOccupiedVoxel) {
  const VoxelMap map = room_with_block({-3, 10, 0}, {-1, 12, 2});
  ASSERT_EQ(map.occupied_voxels(), 8u);
  const std::vector<std::uint8_t> bytes = encode_ply(map);
  const std::string text(bytes.begin(), bytes.end());
  const std::size_t body = text.find("end_header\n") + 11;
  EXPECT_EQ(text.rfind("ply\nformat binary_little_endian 1.0\n", 0), 0u);
  EXPECT_NE(text.find("element vertex 8\n"), std::string::npos);
  ASSERT_EQ(bytes.size(), body + 8 * 15);
  for (std::size_t at = body; at < bytes.size(); at += 15) {
    float xyz[3];
    std::memcpy(xyz, bytes.data() + at, sizeof(xyz));
    const VoxelState state = map.state(Eigen::Vector3d{xyz[0], xyz[1], xyz[2]});
    EXPECT_EQ(state.voxel_class, VoxelClass::kOccupied) << xyz[0] << " " << xyz[1] << " " << xyz[2];
  }
}

}  // namespace
}  // namespace cairn::mapping
