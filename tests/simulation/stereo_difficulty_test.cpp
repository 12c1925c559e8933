// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <opencv2/calib3d.hpp>
#include <opencv2/core/utility.hpp>

#include "evaluation/stereo_score.hpp"
#include "scenes.hpp"
#include "simulation/drive_path.hpp"
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

TEST(StereoDifficulty, TheRoomIsAsHardForAMatcherAsRealPairsAre) {
  cv::setNumThreads(1);
  const auto world = load_world(room_file());
  ASSERT_TRUE(world) << world.error().message;
  const auto rig = test_rig();
  const auto eyes = Renderer::create(*world, rig, {}, 1);
  ASSERT_TRUE(eyes) << eyes.error().message;
  const auto path = drive_round(room_tour_m(), {});
  const double fB = rig.left.fx_px * rig.baseline_m();
  double density = 0;
  double bad2 = 0;
  int frames = 0;
  for (std::size_t i = 0; i < path.size(); i += 10, ++frames) {
    const RenderedPair pair = eyes->render(path[i].T, static_cast<std::int64_t>(i));
    cv::Mat_<float> truth_px(fB / pair.left_depth_m);
    truth_px.setTo(0, truth_px >= kDisparities - 1);
    const auto score =
        evaluation::score_stereo({match_3way(pair.left, pair.right), truth_px, {}, {}});
    ASSERT_TRUE(score) << score.error().message;
    density += score->density;
    bad2 += score->bad2.value();
  }
  density /= frames;
  bad2 /= frames;
  RecordProperty("density", std::to_string(density));
  RecordProperty("bad2", std::to_string(bad2));
  EXPECT_GE(density, 0.75);
  EXPECT_LE(density, 0.92);
  EXPECT_GE(bad2, 0.02);
  EXPECT_LE(bad2, 0.08);
}

}  // namespace
}  // namespace cairn::simulation
