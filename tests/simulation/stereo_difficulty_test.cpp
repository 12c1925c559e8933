// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <opencv2/calib3d.hpp>
#include <opencv2/core/utility.hpp>
#include <random>

#include "evaluation/stereo_score.hpp"
#include "scenes.hpp"
#include "simulation/reachable_floor.hpp"
#include "simulation/renderer.hpp"

namespace cairn::simulation {
namespace {

constexpr int kDisparities = 160;

/// OpenCV's 3WAY as the project measures its peers; images padded on the left by the range.
cv::Mat_<float> match_3way(const cv::Mat& left, const cv::Mat& right) {
  cv::Mat padded_left;
  cv::Mat padded_right;
  cv::copyMakeBorder(left, padded_left, 0, 0, kDisparities, 0, cv::BORDER_REPLICATE);
  cv::copyMakeBorder(right, padded_right, 0, 0, kDisparities, 0, cv::BORDER_REPLICATE);
  const auto matcher = cv::StereoSGBM::create(0, kDisparities, 5, 8 * 25, 32 * 25, 1, 31, 10, 100,
                                              2, cv::StereoSGBM::MODE_SGBM_3WAY);
  cv::Mat disparity_16ths;
  matcher->compute(padded_left, padded_right, disparity_16ths);
  cv::Mat_<float> disparity_px;
  disparity_16ths.colRange(kDisparities, disparity_16ths.cols)
      .convertTo(disparity_px, CV_32F, 1.0 / 16);
  return disparity_px;
}

/// The robot's cameras, 0.30 m high, rectified.
camera::RigCalibration level_rig() {
  auto rig = test_rig();
  rig.T_body_left.translation() = Eigen::Vector3d(0, 0.127, 0.30);
  return rig;
}

/// A pose where the robot fits, from which nine tenths of the view are within the range of the
/// disparities: a pair of a wall in front of one's nose says nothing.
Isometry view_of(const ReachableFloor& floor, const Renderer& renderer, double nearest_m,
                 std::mt19937& random) {
  for (;;) {
    const Eigen::Vector3d place_m = floor.cells()[random() % floor.cells().size()].middle_m;
    if (!floor.has_room_at(place_m.head<2>())) continue;
    Isometry T = pose_2d(place_m.x(), place_m.y(), 0.001 * static_cast<double>(random() % 6283));
    T.translation() = place_m;
    const auto depth_m = renderer.left_depth_m(T, 8);
    const cv::Mat near = depth_m < nearest_m;
    if (cv::countNonZero(near) <= static_cast<int>(depth_m.total() / 10)) return T;
  }
}

class StereoDifficultyOf : public testing::TestWithParam<const char*> {};

TEST_P(StereoDifficultyOf, IsThatOfRealPairs) {
  cv::setNumThreads(1);
  const auto world = load_world(world_file(GetParam()));
  ASSERT_TRUE(world) << world.error().message;
  const auto floor =
      ReachableFloor::flood(*world, world->T_world_start.translation().head<2>(), {});
  ASSERT_TRUE(floor) << floor.error().message;
  const auto rig = level_rig();
  const auto eyes = Renderer::create(*world, rig, {}, 1);
  ASSERT_TRUE(eyes) << eyes.error().message;
  const double fB = rig.left.fx_px * rig.baseline_m();
  constexpr unsigned kSeed = 8;
  std::mt19937 random(kSeed);
  double density = 0;
  double bad2 = 0;
  constexpr int kViews = 24;
  for (int view = 0; view < kViews; ++view) {
    const Isometry T = view_of(*floor, *eyes, fB / (kDisparities - 1), random);
    const RenderedPair pair = eyes->render(T, view);
    cv::Mat_<float> truth_px(fB / pair.left_depth_m);
    truth_px.setTo(0, truth_px >= kDisparities - 1);
    const auto score =
        evaluation::score_stereo({match_3way(pair.left, pair.right), truth_px, {}, {}});
    ASSERT_TRUE(score) << score.error().message;
    density += score->density / kViews;
    bad2 += score->bad2.value_or(0) / kViews;
  }
  RecordProperty("density", std::to_string(density));
  RecordProperty("bad2", std::to_string(bad2));
  EXPECT_GE(density, 0.75);
  EXPECT_LE(density, 0.92);
  EXPECT_GE(bad2, 0.02);
  EXPECT_LE(bad2, 0.08);
}

INSTANTIATE_TEST_SUITE_P(Worlds, StereoDifficultyOf,
                         testing::Values("room", "apartment", "office", "hand-drawn"),
                         [](const auto& world) {
                           std::string name = world.param;
                           std::erase(name, '-');
                           return name;
                         });

}  // namespace
}  // namespace cairn::simulation
