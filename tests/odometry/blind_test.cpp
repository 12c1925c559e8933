// SPDX-License-Identifier: Apache-2.0
// By the tracks alone.
#include <gtest/gtest.h>

#include <cmath>

#include "odometry/made_tracks.hpp"
#include "odometry/stereo_odometry.hpp"

namespace cairn::odometry {
namespace {

using testing::MadeTracks;
using testing::steady_tracks;

constexpr Utime kFrame_us = 66'667;
Utime time_of(std::size_t i) { return 1'000'000 + static_cast<Utime>(i) * kFrame_us; }

TEST(Blind, IsDeadReckoningInClosedForm) {
  constexpr double kSlip = 0.3;
  const double gauge_m = RobotConfig{}.track_gauge_m;
  MadeTracks tracks{steady_tracks(0.3, 0.4, kSlip, 0)};
  StereoOdometry odometry{StereoOdometryConfig{}};
  const double left_mps = (0.3 - 0.4 * gauge_m / 2) * (1 + kSlip);
  const double right_mps = 0.3 + 0.4 * gauge_m / 2;
  const double turn_radps = (right_mps - left_mps) / gauge_m;
  const double radius_m = (right_mps + left_mps) / 2 / turn_radps;
  for (std::size_t i = 0; i < 150; ++i) {
    const auto estimate = odometry.update_blind(time_of(i), tracks.at(time_of(i)));
    ASSERT_TRUE(estimate);
    const double turn_rad = turn_radps * to_seconds(time_of(i) - time_of(0));
    const Eigen::Vector3d expected(radius_m * std::sin(turn_rad),
                                   radius_m * (1 - std::cos(turn_rad)), 0);
    // A tick is 0.2 mm; two of them over the gauge turn the body by 1.5 mrad.
    EXPECT_LT((estimate->T_odom_body.translation() - expected).norm(), 0.004) << i;
    EXPECT_NEAR(log_so3(estimate->T_odom_body.linear()).z(), std::remainder(turn_rad, 2 * M_PI),
                0.002);
    if (i == 0) continue;
    EXPECT_EQ(estimate->basis, Basis::kTracks);
    EXPECT_NEAR(estimate->twist[0], (left_mps + right_mps) / 2, 0.01);
    EXPECT_NEAR(estimate->twist[5], turn_radps, 0.05);
    EXPECT_GT(estimate->quality, 0);
    EXPECT_LE(estimate->quality, 0.3);
  }
}

TEST(Blind, WithoutTracksItStaysWhereItIsAndSaysSo) {
  StereoOdometry odometry{StereoOdometryConfig{}};
  for (std::size_t i = 0; i < 10; ++i) {
    const auto estimate = odometry.update_blind(time_of(i), std::nullopt);
    ASSERT_TRUE(estimate);
    EXPECT_TRUE(estimate->T_odom_body.matrix().isIdentity());
    EXPECT_EQ(estimate->quality, 0);
    EXPECT_EQ(estimate->coasting, i > 0);
  }
}

TEST(Blind, ACoastedGapIsPutRightWhenTheTracksSpeakAgain) {
  MadeTracks all{steady_tracks(0.3, 0.4)};
  StereoOdometry heard{StereoOdometryConfig{}};
  StereoOdometry gap{StereoOdometryConfig{}};
  OdometryEstimate with;
  OdometryEstimate without;
  for (std::size_t i = 0; i < 40; ++i) {
    const auto moment = all.at(time_of(i));
    const bool silent = i >= 20 && i < 35;
    with = *heard.update_blind(time_of(i), moment);
    without = *gap.update_blind(time_of(i), silent ? std::nullopt : moment);
    EXPECT_EQ(without.coasting, silent);
  }
  EXPECT_LT((with.T_odom_body.translation() - without.T_odom_body.translation()).norm(), 1e-9);
}

TEST(Blind, RefusesATimeThatDoesNotRise) {
  StereoOdometry odometry{StereoOdometryConfig{}};
  ASSERT_TRUE(odometry.update_blind(time_of(5), std::nullopt));
  EXPECT_FALSE(odometry.update_blind(time_of(5), std::nullopt));
  const auto back = odometry.update_blind(time_of(5) - 1'000'001, std::nullopt);
  ASSERT_TRUE(back);
  EXPECT_EQ(back->epoch, 1U);
}

}  // namespace
}  // namespace cairn::odometry
