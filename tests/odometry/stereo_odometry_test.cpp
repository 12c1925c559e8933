// SPDX-License-Identifier: Apache-2.0
#include "odometry/stereo_odometry.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <opencv2/core/utility.hpp>
#include <opencv2/imgproc.hpp>

#include "odometry/rendered_room.hpp"

namespace cairn::odometry {
namespace {

using testing::RenderedRoom;
using testing::robot_camera;

constexpr Utime kFrame_us = 66'667;

struct Step {
  cv::Mat left;
  cv::Mat right;
};

constexpr std::size_t kFrames = 30;

/// 0.3 m/s forward while turning by 0.3 rad/s.
Isometry room_pose(std::size_t i) {
  Twist twist = Twist::Zero();
  twist[0] = 0.3;
  twist[5] = 0.3;
  return Eigen::Translation3d(-1.5, -0.5, 0) *
         motion_of(twist, static_cast<double>(i) * to_seconds(kFrame_us));
}

/// What is seen there at 15 Hz, with noise of two grey levels. Rendered once.
const Step& drive(std::size_t i) {
  static std::array<Step, kFrames> steps;
  Step& step = steps[i];
  if (step.left.empty()) {
    step.left = testing::with_noise(RenderedRoom::left(robot_camera(), room_pose(i)), 2, 2 * i);
    step.right =
        testing::with_noise(RenderedRoom::right(robot_camera(), room_pose(i)), 2, 2 * i + 1);
  }
  return step;
}

Utime time_of(std::size_t i) { return 1'000'000 + static_cast<Utime>(i) * kFrame_us; }

Isometry true_pose(std::size_t i) { return room_pose(0).inverse() * room_pose(i); }

OdometryEstimate feed(StereoOdometry& odometry, std::size_t i) {
  auto estimate = odometry.update(drive(i).left, drive(i).right, robot_camera(), time_of(i));
  EXPECT_TRUE(estimate) << (estimate ? "" : estimate.error().message);
  return *estimate;
}

void expect_finite(const OdometryEstimate& estimate) {
  EXPECT_TRUE(estimate.T_odom_body.matrix().allFinite());
  EXPECT_TRUE(estimate.twist.allFinite());
  EXPECT_TRUE(estimate.step_covariance.allFinite());
  EXPECT_GE(estimate.quality, 0);
  EXPECT_LE(estimate.quality, 1);
}

TEST(StereoOdometry, FollowsAKnownMotion) {
  StereoOdometry odometry{StereoOdometryConfig{}};
  OdometryEstimate estimate;
  for (std::size_t i = 0; i < kFrames; ++i) {
    estimate = feed(odometry, i);
    expect_finite(estimate);
    EXPECT_FALSE(estimate.coasting);
    EXPECT_GT(estimate.quality, 0.9) << i;
    if (i == 0) {
      EXPECT_TRUE(estimate.T_odom_body.matrix().isIdentity());
      continue;
    }
    EXPECT_NEAR(estimate.twist[0], 0.3, 0.05) << i;
    EXPECT_NEAR(estimate.twist[5], 0.3, 0.03) << i;
  }
  const Isometry error = true_pose(kFrames - 1).inverse() * estimate.T_odom_body;
  const double way_m = 0.3 * to_seconds(kFrame_us) * 29;
  std::printf("rendered room, %.2f m: end %.1f mm (%.2f %%), %.3f degrees off\n", way_m,
              1000 * error.translation().norm(), 100 * error.translation().norm() / way_m,
              rotation_angle_rad(error.linear()) * 180 / M_PI);
  EXPECT_LT(error.translation().norm(), 0.01 * way_m);
  EXPECT_LT(rotation_angle_rad(error.linear()), 0.005);
}

TEST(StereoOdometry, StepCovarianceFitsTheStepErrors) {
  StereoOdometry odometry{StereoOdometryConfig{}};
  double sum = 0;
  Isometry before = Isometry::Identity();
  for (std::size_t i = 0; i < kFrames; ++i) {
    const auto estimate = feed(odometry, i);
    if (i > 0) {
      const Isometry true_step = true_pose(i - 1).inverse() * true_pose(i);
      const Isometry error = true_step.inverse() * (before.inverse() * estimate.T_odom_body);
      Vector6d e;
      e << error.translation(), log_so3(error.linear());
      sum += e.dot(estimate.step_covariance.inverse() * e);
    }
    before = estimate.T_odom_body;
  }
  const double mean = sum / static_cast<double>(kFrames - 1);
  std::printf("rendered room: mean normalised squared step error %.1f (6 is consistent)\n", mean);
  EXPECT_GT(mean, 1.5);
  EXPECT_LT(mean, 18);
}

TEST(StereoOdometry, StandsStill) {
  StereoOdometry odometry{StereoOdometryConfig{}};
  const auto& step = drive(0);
  const auto camera = robot_camera();
  for (std::size_t i = 0; i < 20; ++i) {
    const auto seed = static_cast<std::uint64_t>(1000 + 2 * i);
    const auto estimate =
        odometry.update(testing::with_noise(step.left, 3, seed),
                        testing::with_noise(step.right, 3, seed + 1), camera, time_of(i));
    ASSERT_TRUE(estimate);
    EXPECT_LT(estimate->T_odom_body.translation().norm(), 0.002) << i;
    EXPECT_LT(rotation_angle_rad(estimate->T_odom_body.linear()), 0.001) << i;
  }
}

TEST(StereoOdometry, CoastsThroughTheDarkAndSaysSo) {
  StereoOdometry odometry{StereoOdometryConfig{}};
  for (std::size_t i = 0; i < 8; ++i) feed(odometry, i);
  const cv::Mat dark = cv::Mat::zeros(480, 640, CV_8UC1);
  for (std::size_t i = 8; i < 12; ++i) {
    const auto estimate = odometry.update(dark, dark, robot_camera(), time_of(i));
    ASSERT_TRUE(estimate);
    expect_finite(*estimate);
    EXPECT_TRUE(estimate->coasting);
    EXPECT_EQ(estimate->quality, 0);
    EXPECT_LT((estimate->T_odom_body.translation() - true_pose(i).translation()).norm(), 0.02);
    EXPECT_GT(estimate->step_covariance(0, 0), 1e-4);
  }
  OdometryEstimate estimate;
  for (std::size_t i = 12; i < 20; ++i) {
    estimate = feed(odometry, i);
    EXPECT_FALSE(estimate.coasting) << i;
    EXPECT_NEAR(estimate.twist[0], 0.3, 0.05) << i;
  }
  EXPECT_LT((estimate.T_odom_body.translation() - true_pose(19).translation()).norm(), 0.005);
  EXPECT_EQ(estimate.epoch, 0U);
}

TEST(StereoOdometry, StartsAfreshWhereItSeesNothingItKnows) {
  StereoOdometry odometry{StereoOdometryConfig{}};
  for (std::size_t i = 0; i < 4; ++i) feed(odometry, i);
  Isometry elsewhere = Isometry::Identity();
  elsewhere.linear() = rotation_from_rpy(0, 0, 2.5);
  const cv::Mat left = RenderedRoom::left(robot_camera(), elsewhere);
  const cv::Mat right = RenderedRoom::right(robot_camera(), elsewhere);
  const auto lost = odometry.update(left, right, robot_camera(), time_of(4));
  ASSERT_TRUE(lost);
  EXPECT_TRUE(lost->coasting);
  const auto found = odometry.update(left, right, robot_camera(), time_of(5));
  ASSERT_TRUE(found);
  EXPECT_FALSE(found->coasting);
  EXPECT_LT(found->twist.norm(), 0.05) << "a jump of the picture is no velocity";
}

TEST(StereoOdometry, StopsCoastingAfterAWhile) {
  StereoOdometryConfig config;
  config.coast_s = 0.2;
  StereoOdometry odometry{config};
  for (std::size_t i = 0; i < 8; ++i) feed(odometry, i);
  const cv::Mat dark = cv::Mat::zeros(480, 640, CV_8UC1);
  OdometryEstimate estimate;
  for (std::size_t i = 8; i < 40; ++i) {
    estimate = *odometry.update(dark, dark, robot_camera(), time_of(i));
    expect_finite(estimate);
  }
  EXPECT_TRUE(estimate.twist.isZero());
  EXPECT_NEAR((estimate.T_odom_body.translation() - true_pose(7).translation()).norm(), 0.2 * 0.3,
              0.01);
}

TEST(StereoOdometry, StartsInTheDark) {
  StereoOdometry odometry{StereoOdometryConfig{}};
  const cv::Mat dark = cv::Mat::zeros(480, 640, CV_8UC1);
  const auto first = odometry.update(dark, dark, robot_camera(), 1);
  ASSERT_TRUE(first);
  EXPECT_TRUE(first->T_odom_body.matrix().isIdentity());
  EXPECT_EQ(first->quality, 0);
  const auto second = odometry.update(dark, dark, robot_camera(), 2);
  ASSERT_TRUE(second);
  expect_finite(*second);
  EXPECT_TRUE(second->coasting);
}

TEST(StereoOdometry, ABlurredFrameDoesNotThrowItOff) {
  StereoOdometry odometry{StereoOdometryConfig{}};
  OdometryEstimate estimate;
  for (std::size_t i = 0; i < 14; ++i) {
    if (i == 7) {
      cv::Mat left;
      cv::Mat right;
      cv::blur(drive(i).left, left, {61, 61});
      cv::blur(drive(i).right, right, {61, 61});
      const auto blurred = odometry.update(left, right, robot_camera(), time_of(i));
      ASSERT_TRUE(blurred);
      expect_finite(*blurred);
      continue;
    }
    estimate = feed(odometry, i);
  }
  EXPECT_FALSE(estimate.coasting);
  EXPECT_LT((estimate.T_odom_body.translation() - true_pose(13).translation()).norm(), 0.005);
}

TEST(StereoOdometry, RefusesATimeThatDoesNotRise) {
  StereoOdometry odometry{StereoOdometryConfig{}};
  feed(odometry, 0);
  const auto known = feed(odometry, 1);
  const auto& step = drive(2);
  EXPECT_FALSE(odometry.update(step.left, step.right, robot_camera(), time_of(1)));
  EXPECT_FALSE(odometry.update(step.left, step.right, robot_camera(), time_of(1) - 500'000));
  const auto next = feed(odometry, 2);
  EXPECT_EQ(next.epoch, known.epoch);
  EXPECT_FALSE(next.coasting) << "a refused frame must leave no trace";
}

TEST(StereoOdometry, BeginsANewEpochWhenTimeJumpsBack) {
  StereoOdometry odometry{StereoOdometryConfig{}};
  for (std::size_t i = 0; i < 5; ++i) feed(odometry, i);
  const auto before = odometry.checkpoint();
  const auto& step = drive(5);
  const auto jumped =
      odometry.update(step.left, step.right, robot_camera(), time_of(4) - 1'000'001);
  ASSERT_TRUE(jumped);
  expect_finite(*jumped);
  EXPECT_EQ(jumped->epoch, 1U);
  EXPECT_TRUE(jumped->coasting);
  EXPECT_TRUE(jumped->T_odom_body.isApprox(before.T_odom_body, 1e-12));
  const auto after =
      odometry.update(drive(6).left, drive(6).right, robot_camera(), time_of(5) - 1'000'001);
  ASSERT_TRUE(after);
  EXPECT_FALSE(after->coasting);
  EXPECT_EQ(after->epoch, 1U);
}

TEST(StereoOdometry, GoesOnAfterARestart) {
  StereoOdometry first{StereoOdometryConfig{}};
  for (std::size_t i = 0; i < 12; ++i) feed(first, i);
  const auto kept = checkpoint_from_bytes(to_bytes(first.checkpoint()));
  ASSERT_TRUE(kept);

  StereoOdometry second{StereoOdometryConfig{}};
  second.resume(*kept);
  const auto placed = feed(second, 16);
  expect_finite(placed);
  EXPECT_EQ(placed.epoch, 1U);
  EXPECT_TRUE(placed.coasting);
  EXPECT_LT((placed.T_odom_body.translation() - true_pose(16).translation()).norm(), 0.02);
  EXPECT_GT(std::sqrt(placed.step_covariance(0, 0)), 0.02) << "the gap must show";
  OdometryEstimate estimate;
  for (std::size_t i = 17; i < 30; ++i) {
    estimate = feed(second, i);
    EXPECT_FALSE(estimate.coasting);
  }
  EXPECT_LT((estimate.T_odom_body.translation() - true_pose(29).translation()).norm(), 0.03);
}

TEST(StereoOdometry, ResumesAtAnyTime) {
  StereoOdometry first{StereoOdometryConfig{}};
  for (std::size_t i = 0; i < 5; ++i) feed(first, i);
  const auto kept = first.checkpoint();
  for (const Utime utime : {kept.utime, kept.utime - 100, kept.utime - 10'000'000, Utime{0},
                            kept.utime + 3'600'000'000}) {
    StereoOdometry odometry{StereoOdometryConfig{}};
    odometry.resume(kept);
    const auto placed = odometry.update(drive(5).left, drive(5).right, robot_camera(), utime);
    ASSERT_TRUE(placed) << utime;
    expect_finite(*placed);
    EXPECT_EQ(placed->epoch, 1U);
    EXPECT_LT((placed->T_odom_body.translation() - kept.T_odom_body.translation()).norm(), 0.2);
  }
}

TEST(StereoOdometry, GivesTheSameBytesAgainAndOnTwoThreads) {
  const int threads = cv::getNumThreads();
  std::vector<OdometryEstimate> runs[2];
  for (int run = 0; run < 2; ++run) {
    cv::setNumThreads(run + 1);
    StereoOdometry odometry{StereoOdometryConfig{}};
    for (std::size_t i = 0; i < 10; ++i) runs[run].push_back(feed(odometry, i));
  }
  cv::setNumThreads(threads);
  for (std::size_t i = 0; i < runs[0].size(); ++i) {
    EXPECT_EQ(runs[0][i].T_odom_body.matrix(), runs[1][i].T_odom_body.matrix());
    EXPECT_EQ(runs[0][i].step_covariance, runs[1][i].step_covariance);
    EXPECT_EQ(runs[0][i].inliers, runs[1][i].inliers);
  }
}

TEST(StereoOdometry, SettledAtOnceOrLaterItIsTheSame) {
  StereoOdometry later{StereoOdometryConfig{}};
  StereoOdometry at_once{StereoOdometryConfig{}};
  for (std::size_t i = 0; i < 12; ++i) {
    const auto a = feed(later, i);
    const auto b = feed(at_once, i);
    ASSERT_TRUE(at_once.settle());
    EXPECT_EQ(a.T_odom_body.matrix(), b.T_odom_body.matrix());
    EXPECT_EQ(a.step_covariance, b.step_covariance);
    EXPECT_EQ(a.tracked, b.tracked);
  }
}

TEST(StereoOdometry, ImagesMayChangeOnceItHasAnswered) {
  StereoOdometry kept{StereoOdometryConfig{}};
  StereoOdometry reused{StereoOdometryConfig{}};
  for (std::size_t i = 0; i < 12; ++i) {
    cv::Mat left = drive(i).left.clone();
    cv::Mat right = drive(i).right.clone();
    const auto a = feed(kept, i);
    const auto b = reused.update(left, right, robot_camera(), time_of(i));
    ASSERT_TRUE(b);
    left.setTo(0);
    right.setTo(0);
    EXPECT_EQ(a.T_odom_body.matrix(), b->T_odom_body.matrix()) << i;
  }
}

TEST(StereoOdometry, TakesANewCalibrationInItsStride) {
  StereoOdometry odometry{StereoOdometryConfig{}};
  for (std::size_t i = 0; i < 3; ++i) feed(odometry, i);
  auto camera = robot_camera();
  camera.f_px = 560;
  const auto changed = odometry.update(drive(3).left, drive(3).right, camera, time_of(3));
  ASSERT_TRUE(changed);
  expect_finite(*changed);
  EXPECT_TRUE(changed->coasting);
  EXPECT_LT((changed->T_odom_body.translation() - true_pose(3).translation()).norm(), 0.01);
}

TEST(StereoOdometry, RefusesBadInput) {
  StereoOdometry odometry{StereoOdometryConfig{}};
  const auto refused = [&](const cv::Mat& left, const cv::Mat& right,
                           const stereo::RectifiedCamera& camera) {
    const auto estimate = odometry.update(left, right, camera, 1);
    return !estimate && !estimate.error().message.empty();
  };
  const auto camera = robot_camera();
  const cv::Mat good = cv::Mat::zeros(480, 640, CV_8UC1);
  EXPECT_TRUE(refused(cv::Mat(), cv::Mat(), camera));
  EXPECT_TRUE(refused(good, cv::Mat::zeros(480, 638, CV_8UC1), camera));
  EXPECT_TRUE(refused(cv::Mat::zeros(480, 640, CV_8UC3), good, camera));
  EXPECT_TRUE(
      refused(cv::Mat::zeros(240, 320, CV_8UC1), cv::Mat::zeros(240, 320, CV_8UC1), camera));
  auto broken = camera;
  broken.f_px = std::nan("");
  EXPECT_TRUE(refused(good, good, broken));
  broken = camera;
  broken.baseline_m = 0;
  EXPECT_TRUE(refused(good, good, broken));
  EXPECT_FALSE(refused(good, good, camera));
}

}  // namespace
}  // namespace cairn::odometry
