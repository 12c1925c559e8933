// SPDX-License-Identifier: Apache-2.0
#include "odometry/stereo_pose.hpp"

#include <gtest/gtest.h>

#include <random>

#include "odometry/rendered_room.hpp"

namespace cairn::odometry {
namespace {

struct Scene {
  std::vector<PointPair> pairs;
  std::vector<bool> is_wrong;
};

/// Points 0.7 to 8 m away, seen from two places with Gaussian noise; some pairs are pure chance.
Scene make_scene(const Isometry& T_new_anchor, const stereo::RectifiedCamera& camera, int count,
                 double wrong_share, const PixelNoise& noise, double anchor_sigma_px,
                 std::mt19937& random) {
  std::uniform_real_distribution<double> uniform(0, 1);
  std::normal_distribution<double> normal;
  const double fb = camera.f_px * camera.baseline_m;
  Scene scene;
  while (scene.pairs.size() < static_cast<std::size_t>(count)) {
    const StereoPixel pixel{640 * uniform(random), 480 * uniform(random),
                            fb / (0.7 + 7.3 * uniform(random))};
    StereoPixel seen = to_pixel(T_new_anchor * to_point(pixel, camera), camera);
    const bool wrong = uniform(random) < wrong_share;
    if (wrong) seen = {640 * uniform(random), 480 * uniform(random), 5 + 150 * uniform(random)};
    seen.u_px += noise.position_sigma_px * normal(random);
    seen.v_px += noise.position_sigma_px * normal(random);
    seen.disparity_px += noise.disparity_sigma_px * normal(random);
    StereoPixel anchor = pixel;
    anchor.disparity_px += anchor_sigma_px * normal(random);
    scene.pairs.push_back({anchor, anchor_sigma_px, seen});
    scene.is_wrong.push_back(wrong);
  }
  return scene;
}

Isometry some_motion() {
  Isometry T = Isometry::Identity();
  T.linear() = rotation_from_rpy(0.02, -0.06, 0.01);
  T.translation() = Eigen::Vector3d(0.03, -0.01, -0.12);
  return T;
}

TEST(StereoPose, IsExactWithoutNoise) {
  const auto camera = testing::robot_camera();
  std::mt19937 random(1);
  const auto scene = make_scene(some_motion(), camera, 60, 0, {1e-9, 1e-9}, 1e-9, random);
  const auto pose = solve_stereo_pose(scene.pairs, camera, {}, Isometry::Identity(), 12, 1);
  ASSERT_TRUE(pose);
  EXPECT_TRUE(pose->T_new_anchor.isApprox(some_motion(), 1e-6));
  EXPECT_EQ(pose->inliers, 60);
}

TEST(StereoPose, FindsThePoseAmongWrongPairs) {
  const auto camera = testing::robot_camera();
  for (const double wrong_share : {0.2, 0.4, 0.5}) {
    std::mt19937 random(7);
    const PixelNoise noise;
    const auto scene = make_scene(some_motion(), camera, 150, wrong_share, noise, 0.2, random);
    const auto pose = solve_stereo_pose(scene.pairs, camera, noise, Isometry::Identity(), 12, 1);
    ASSERT_TRUE(pose) << wrong_share;
    const Isometry error = some_motion().inverse() * pose->T_new_anchor;
    EXPECT_LT(error.translation().norm(), 0.004) << wrong_share;
    EXPECT_LT(rotation_angle_rad(error.linear()), 0.002) << wrong_share;
    for (std::size_t i = 0; i < scene.pairs.size(); ++i) {
      EXPECT_FALSE(scene.is_wrong[i] && pose->is_inlier[i]) << "pair " << i;
    }
  }
}

TEST(StereoPose, CovarianceFitsTheErrors) {
  // The normalised squared error of a consistent 6-D estimate has mean 6 (Bar-Shalom, Li and
  // Kirubarajan 2001, 5.4).
  const auto camera = testing::robot_camera();
  for (const double actual_scale : {1.0, 2.0}) {
    std::mt19937 random(11);
    const PixelNoise assumed;
    const PixelNoise actual{actual_scale * assumed.position_sigma_px,
                            actual_scale * assumed.disparity_sigma_px};
    double sum = 0;
    constexpr int kTrials = 200;
    for (int trial = 0; trial < kTrials; ++trial) {
      const auto scene =
          make_scene(some_motion(), camera, 80, 0, actual, 0.2 * actual_scale, random);
      auto pairs = scene.pairs;
      for (auto& pair : pairs) pair.anchor_sigma_px = 0.2;
      const auto pose = solve_stereo_pose(pairs, camera, assumed, Isometry::Identity(), 12, 1);
      ASSERT_TRUE(pose);
      const Isometry error = pose->T_new_anchor * some_motion().inverse();
      Vector6d e;
      e << error.translation(), log_so3(error.linear());
      sum += e.dot(pose->covariance.inverse() * e);
    }
    EXPECT_GT(sum / kTrials, 4.0) << actual_scale;
    EXPECT_LT(sum / kTrials, actual_scale == 1.0 ? 8.0 : 12.0) << actual_scale;
  }
}

TEST(StereoPose, SaysSoWhenThereIsNone) {
  const auto camera = testing::robot_camera();
  std::mt19937 random(3);
  EXPECT_FALSE(solve_stereo_pose({}, camera, {}, Isometry::Identity(), 12, 1));
  const auto chance = make_scene(some_motion(), camera, 100, 1.0, {}, 0.2, random);
  EXPECT_FALSE(solve_stereo_pose(chance.pairs, camera, {}, Isometry::Identity(), 12, 1));
  const auto few = make_scene(some_motion(), camera, 11, 0, {}, 0.2, random);
  EXPECT_FALSE(solve_stereo_pose(few.pairs, camera, {}, Isometry::Identity(), 12, 1));
  auto one_point = make_scene(some_motion(), camera, 1, 0, {}, 0.2, random).pairs;
  one_point.resize(50, one_point.front());
  EXPECT_FALSE(solve_stereo_pose(one_point, camera, {}, Isometry::Identity(), 12, 1))
      << "one point, however often, leaves the pose open";
}

TEST(StereoPose, SameArgumentsSameResult) {
  const auto camera = testing::robot_camera();
  std::mt19937 random(5);
  const auto scene = make_scene(some_motion(), camera, 100, 0.4, {}, 0.2, random);
  const auto a = solve_stereo_pose(scene.pairs, camera, {}, Isometry::Identity(), 12, 9);
  const auto b = solve_stereo_pose(scene.pairs, camera, {}, Isometry::Identity(), 12, 9);
  ASSERT_TRUE(a && b);
  EXPECT_EQ(a->T_new_anchor.matrix(), b->T_new_anchor.matrix());
  EXPECT_EQ(a->covariance, b->covariance);
}

}  // namespace
}  // namespace cairn::odometry
