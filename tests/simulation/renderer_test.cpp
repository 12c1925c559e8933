// SPDX-License-Identifier: Apache-2.0
#include "simulation/renderer.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <random>

#include "scenes.hpp"
#include "simulation/depth_renderer.hpp"
#include "slab_ray.hpp"

namespace cairn::simulation {
namespace {

const SensorConfig kPerfect{0, 0, 1, 0, 0, 450};

Renderer renderer(const World& world, const camera::RigCalibration& rig,
                  const SensorConfig& sensor = kPerfect, std::uint64_t seed = 1) {
  auto made = Renderer::create(world, rig, sensor, seed);
  EXPECT_TRUE(made) << made.error().message;
  return std::move(*made);
}

World room() { return load_world(room_file()).value(); }

bool same(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && a.type() == b.type() && cv::norm(a, b, cv::NORM_INF) == 0;
}

double mean_difference(const cv::Mat& a, const cv::Mat& b, const cv::Mat& mask) {
  cv::Mat difference;
  cv::absdiff(a, b, difference);
  return cv::mean(difference, mask)[0];
}

TEST(Renderer, AWallAheadHasOneDepth) {
  // The camera stands at x = 0.1; the wall's face at x = 3.
  const World world = world_of({box({3.5, 0, 0}, {1, 8, 8})});
  const auto depth_m = renderer(world, test_rig()).left_depth_m(Isometry::Identity());
  double low = 0;
  double high = 0;
  cv::minMaxLoc(depth_m, &low, &high);
  EXPECT_NEAR(low, 2.9, 1e-6);
  EXPECT_NEAR(high, 2.9, 1e-6);
}

TEST(Renderer, TheFloorsDepthFollowsTheRow) {
  // A level camera 0.45 m up: row v meets the floor at depth 0.45 f / (v - cy); above the horizon
  // is nothing.
  const World world = world_of({box({0, 0, -1}, {60, 60, 2})});
  const auto rig = test_rig();
  const auto depth_m = renderer(world, rig).left_depth_m(pose_2d(1, 2, 0.7));
  for (int row = 260; row < 480; row += 20) {
    const double expected_m = 0.45 * rig.left.fy_px / (row - rig.left.cy_px);
    EXPECT_NEAR(depth_m(row, 17), expected_m, 1e-5 * expected_m);
  }
  EXPECT_EQ(depth_m(100, 100), 0);
}

TEST(Renderer, DepthAgreesWithSlabRaysEverywhereInTheRoom) {
  const World world = room();
  const auto rig = test_rig(320, 240);
  const Renderer eyes = renderer(world, rig);
  std::mt19937 random(17);
  std::uniform_real_distribution<double> unit(-1, 1);
  int pixels = 0;
  int off = 0;
  for (int view = 0; view < 12; ++view) {
    Isometry T = pose_2d(0.9 * unit(random), 0.8 + 0.1 * unit(random), 3 * unit(random));
    T.linear() *= rotation_from_rpy(0.2 * unit(random), 0.2 * unit(random), 0);
    const Isometry T_world_right = T * rig.T_body_left * rig.T_right_left.inverse();
    const auto left_m = eyes.left_depth_m(T);
    const auto right_m = eyes.right_depth_m(T);
    for (const auto& [depth_m, T_world_eye] :
         {std::pair{left_m, Isometry(T * rig.T_body_left)}, std::pair{right_m, T_world_right}}) {
      for (int row = 0; row < 240; row += 3) {
        for (int col = 0; col < 320; col += 3) {
          const Eigen::Vector3d ray((col - rig.left.cx_px) / rig.left.fx_px,
                                    (row - rig.left.cy_px) / rig.left.fy_px, 1);
          const double expected_m =
              first_hit(world, T_world_eye.translation(), T_world_eye.linear() * ray);
          ++pixels;
          off += !(std::abs(depth_m(row, col) - expected_m) < 2e-5 * expected_m);
        }
      }
    }
  }
  // Single and double precision may see another box at its very edge.
  EXPECT_LT(off, pixels / 5000) << "of " << pixels;
}

TEST(Renderer, TheRightImageWarpedByTrueDepthIsTheLeftImage) {
  const auto rig = test_rig();
  const Isometry T = pose_2d(0, -0.95, 0);
  const Renderer eyes = renderer(room(), rig);
  const RenderedPair pair = eyes.render(T, 0);
  const auto right_depth_m = eyes.right_depth_m(T);
  cv::Mat_<cv::Vec2f> where(pair.left.size());
  cv::Mat_<std::uint8_t> both(pair.left.size(), static_cast<std::uint8_t>(0));
  const double fB = rig.left.fx_px * rig.baseline_m();
  for (int row = 0; row < where.rows; ++row) {
    for (int col = 0; col < where.cols; ++col) {
      const double depth_m = pair.left_depth_m(row, col);
      const double x = col - fB / depth_m;
      where(row, col) = cv::Vec2f(static_cast<float>(x), static_cast<float>(row));
      if (x < 1 || x > where.cols - 2) continue;
      const auto nearest = static_cast<int>(std::lround(x));
      if (std::abs(right_depth_m(row, nearest) - depth_m) < 0.02 * depth_m) both(row, col) = 255;
    }
  }
  cv::Mat warped;
  cv::remap(pair.right, warped, where, cv::noArray(), cv::INTER_LINEAR);
  EXPECT_GT(cv::countNonZero(both), 640 * 480 / 2);
  cv::Scalar mean;
  cv::Scalar contrast;
  cv::meanStdDev(pair.left, mean, contrast, both);
  const double difference = mean_difference(pair.left, warped, both);
  EXPECT_LT(difference, 2.0);
  EXPECT_LT(difference, 0.1 * contrast[0]);
  // A depth 3 % off does worse: the match is sharp.
  for (auto& at : where) at[0] += 1.0F;
  cv::remap(pair.right, warped, where, cv::noArray(), cv::INTER_LINEAR);
  EXPECT_GT(mean_difference(pair.left, warped, both), 1.5 * difference);
}

TEST(Renderer, TheRightCameraHasItsOwnExposure) {
  // Both cameras of a rig with no baseline to speak of see the same.
  auto rig = test_rig(160, 120);
  rig.T_right_left.translation().x() = -0.002;
  SensorConfig sensor = kPerfect;
  sensor.right_gain = 1.2;
  sensor.right_offset_grey = 5;
  const World world = world_of({box({5, 0, 0}, {1, 20, 20})});
  const RenderedPair pair = renderer(world, rig, sensor).render(Isometry::Identity(), 0);
  const double left = cv::mean(pair.left)[0];
  EXPECT_GT(left, 30);
  EXPECT_NEAR(cv::mean(pair.right)[0], 1.2 * left + 5, 0.7);
}

TEST(Renderer, NoiseIsAsStrongAsItIsSaidToBe) {
  SensorConfig sensor = kPerfect;
  sensor.read_noise_grey = 3;
  sensor.shot_noise_grey = 0.05;
  const World world = room();
  const auto rig = test_rig();
  const cv::Mat clean = renderer(world, rig).render(pose_2d(0, -1, 0), 0).left;
  const cv::Mat noisy = renderer(world, rig, sensor).render(pose_2d(0, -1, 0), 0).left;
  cv::Mat difference;
  cv::subtract(noisy, clean, difference, cv::noArray(), CV_32F);
  cv::Mat variance_of;
  clean.convertTo(variance_of, CV_32F, 0.05, 9);
  const double expected = cv::mean(variance_of)[0];
  cv::Scalar mean;
  cv::Scalar deviation;
  cv::meanStdDev(difference, mean, deviation);
  EXPECT_NEAR(mean[0], 0, 0.05);
  // Rounding to whole grey values adds 1/12 each.
  EXPECT_NEAR(deviation[0] * deviation[0], expected + 1.0 / 6, 0.03 * expected);
}

TEST(Renderer, ExposureWandersSlowlyAndInBothCamerasAlike) {
  SensorConfig sensor = kPerfect;
  sensor.exposure_drift = 0.1;
  sensor.exposure_period_frames = 300;
  const World world = world_of({box({5, 0, 0}, {1, 20, 20})});
  const Renderer eyes = renderer(world, test_rig(160, 120), sensor, 3);
  EXPECT_EQ(eyes.exposure(0), 1);
  const RenderedPair first = eyes.render(Isometry::Identity(), 0);
  double lowest = 1;
  double highest = 1;
  for (int frame = 1; frame < 1000; ++frame) {
    EXPECT_LT(std::abs(eyes.exposure(frame) - eyes.exposure(frame - 1)), 0.003);
    lowest = std::min(lowest, eyes.exposure(frame));
    highest = std::max(highest, eyes.exposure(frame));
  }
  EXPECT_GE(lowest, 0.9);
  EXPECT_LE(highest, 1.1);
  EXPECT_GT(highest - lowest, 0.05);
  const RenderedPair later = eyes.render(Isometry::Identity(), 700);
  const double exposure = eyes.exposure(700);
  EXPECT_NEAR(cv::mean(later.left)[0], exposure * cv::mean(first.left)[0], 0.5);
  EXPECT_NEAR(cv::mean(later.right)[0], exposure * cv::mean(first.right)[0], 0.5);
  EXPECT_NE(renderer(world, test_rig(160, 120), sensor, 4).exposure(700), exposure);
}

TEST(Renderer, CoarseDepthIsEveryFourthPixelOfDepth) {
  const Renderer eyes = renderer(load_world(world_file("apartment")).value(), simulated_rig());
  const Isometry T = pose_2d(-2.4, -0.95, 1);
  const auto fine_m = eyes.left_depth_m(T);
  const auto coarse_m = eyes.left_depth_m(T, 4);
  ASSERT_EQ(coarse_m.size(), cv::Size(160, 120));
  int off = 0;
  for (int row = 0; row < 120; ++row) {
    for (int col = 0; col < 160; ++col) off += coarse_m(row, col) != fine_m(4 * row, 4 * col);
  }
  EXPECT_LE(off, 2);  // ties at borders
}

TEST(DepthRenderer, GivesARenderersDepth) {
  const World world = load_world(world_file("room")).value();
  const Renderer eyes = renderer(world, simulated_rig());
  const auto depth = DepthRenderer::create(world, simulated_rig());
  ASSERT_TRUE(depth) << depth.error().message;
  const Isometry T = pose_2d(-1.2, -1.1, 0.5);
  for (const std::vector<PersonPose>& people :
       {std::vector<PersonPose>{}, std::vector<PersonPose>{{1, {0.6, -0.2}, 1, 0.3}}}) {
    EXPECT_TRUE(same(depth->left_m(T, 2, people), eyes.left_depth_m(T, 2, people)));
    EXPECT_TRUE(same(depth->right_m(T, 4, people), eyes.right_depth_m(T, 4, people)));
  }
}

TEST(Renderer, APersonStandsWhereTheyAreSaidTo) {
  WorldConfig config;
  config.materials.emplace_back().name = "stuff";
  config.boxes = {box({0, 0, -0.1}, {20, 20, 0.2}), box({6, 0, 1}, {1, 20, 4})};
  config.people.emplace_back().waypoints = {{{3, 0}}, {{3, 1}}};
  const auto world = make_world(config, "test");
  ASSERT_TRUE(world) << world.error().message;
  const auto rig = test_rig();
  const Renderer eyes = renderer(*world, rig);
  const std::vector<PersonPose> people{{0, {3, 0}, 0.8, 0.4}};
  const RenderedPair alone = eyes.render(Isometry::Identity(), 0);
  const RenderedPair seen = eyes.render(Isometry::Identity(), 0, people);
  int nearer = 0;
  for (int row = 0; row < 480; ++row) {
    for (int col = 0; col < 640; ++col) {
      const double depth_m = seen.left_depth_m(row, col);
      if (depth_m == alone.left_depth_m(row, col)) continue;
      ++nearer;
      EXPECT_LT(depth_m, alone.left_depth_m(row, col));
      // In world axes: the camera looks along x from (0.1, 0.127, 0.45).
      const double x_m = 0.1 + depth_m;
      const double y_m = 0.127 - depth_m * (col - rig.left.cx_px) / rig.left.fx_px;
      const double z_m = 0.45 - depth_m * (row - rig.left.cy_px) / rig.left.fy_px;
      EXPECT_LT(std::hypot(x_m - 3, y_m), 0.25);
      EXPECT_GT(z_m, -1e-4);
      EXPECT_LT(z_m, 1.75 + 1e-4);
    }
  }
  EXPECT_GT(nearer, 5000);
  EXPECT_GT(mean_difference(alone.left, seen.left, seen.left_depth_m != alone.left_depth_m), 5);
  EXPECT_TRUE(same(eyes.left_depth_m(Isometry::Identity(), 1, people), seen.left_depth_m));
  // Somebody whom the world does not know is not there.
  const std::vector<PersonPose> nobody{{1, {3, 0}, 0, 0}};
  EXPECT_TRUE(same(eyes.render(Isometry::Identity(), 0, nobody).left, alone.left));
}

TEST(Renderer, TheSymmetricRoomLooksTheSameAfterHalfATurn) {
  const Renderer eyes = renderer(load_world(world_file("symmetric-room")).value(), simulated_rig());
  for (const auto& [x, y, heading] : {std::tuple{-1.5, -0.6, 0.0}, std::tuple{0.4, 0.9, 2.0}}) {
    const RenderedPair here = eyes.render(pose_2d(x, y, heading), 0);
    const RenderedPair there = eyes.render(pose_2d(-x, -y, heading + 3.14159265358979323846), 0);
    EXPECT_LT(cv::norm(here.left, there.left, cv::NORM_L1), 0.01 * 640 * 480);
    EXPECT_LT(cv::norm(here.left_depth_m, there.left_depth_m, cv::NORM_INF), 1e-4);
  }
}

TEST(Renderer, TheSameSeedGivesTheSameBytesAndAnotherOnlyAnotherNoise) {
  const World world = room();
  const auto rig = test_rig(320, 240);
  const Isometry T = pose_2d(0.3, -0.8, 0.4);
  const RenderedPair first = renderer(world, rig, {}, 1).render(T, 4);
  const RenderedPair again = renderer(world, rig, {}, 1).render(T, 4);
  EXPECT_TRUE(same(first.left, again.left));
  EXPECT_TRUE(same(first.right, again.right));
  EXPECT_TRUE(same(first.left_depth_m, again.left_depth_m));
  for (const RenderedPair& other :
       {renderer(world, rig, {}, 2).render(T, 4), renderer(world, rig, {}, 1).render(T, 5)}) {
    EXPECT_FALSE(same(first.left, other.left));
    EXPECT_TRUE(same(first.left_depth_m, other.left_depth_m));
    EXPECT_LT(mean_difference(first.left, other.left, cv::Mat()), 4);
  }
}

TEST(Renderer, ABentLensIsStraightenedByItsOwnCalibration) {
  const auto straight_rig = test_rig();
  auto bent_rig = straight_rig;
  bent_rig.rectified = false;
  bent_rig.left.distortion = camera::Distortion::kRadialTangential;
  bent_rig.left.coefficients = {-0.25, 0.08, 0.001, -0.0005};
  bent_rig.right.distortion = camera::Distortion::kEquidistant;
  bent_rig.right.coefficients = {0.02, -0.01, 0.002, 0};
  const World world = room();
  const Isometry T = pose_2d(0, -0.95, 0);
  const RenderedPair straight = renderer(world, straight_rig).render(T, 0);
  const RenderedPair bent = renderer(world, bent_rig).render(T, 0);
  const auto K = straight_rig.left.K();
  cv::Mat map_x;
  cv::Mat map_y;
  const auto check = [&](const cv::Mat& bent_image, const cv::Mat& straight_image) {
    cv::Mat straightened;
    cv::remap(bent_image, straightened, map_x, map_y, cv::INTER_LINEAR);
    const cv::Mat inside = (map_x >= 0) & (map_x <= 639) & (map_y >= 0) & (map_y <= 479);
    EXPECT_GT(cv::countNonZero(inside), 640 * 480 / 2);
    EXPECT_LT(mean_difference(straightened, straight_image, inside), 2.5);
    EXPECT_GT(mean_difference(bent_image, straight_image, inside), 5);
  };
  cv::initUndistortRectifyMap(K, bent_rig.left.coefficients, cv::noArray(), K, {640, 480}, CV_32FC1,
                              map_x, map_y);
  check(bent.left, straight.left);
  cv::fisheye::initUndistortRectifyMap(K, bent_rig.right.coefficients, cv::Matx33d::eye(), K,
                                       {640, 480}, CV_32FC1, map_x, map_y);
  check(bent.right, straight.right);
}

TEST(Renderer, ALensThatFoldsTheImageIsRefused) {
  auto rig = test_rig();
  rig.rectified = false;
  rig.left.distortion = camera::Distortion::kRadialTangential;
  rig.left.coefficients = {-3, 0, 0, 0};
  const auto made = Renderer::create(room(), rig, {}, 1);
  ASSERT_FALSE(made);
  EXPECT_EQ(made.error().message.find("left camera: the distortion cannot be inverted"), 0U)
      << made.error().message;
}

}  // namespace
}  // namespace cairn::simulation
