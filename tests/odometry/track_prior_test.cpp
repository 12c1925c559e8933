// SPDX-License-Identifier: Apache-2.0
#include "odometry/track_prior.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace cairn::odometry {
namespace {

constexpr Utime kFrom = 1'000'000;
constexpr Utime kTo = 1'066'667;

/// A moment that rests on a reading of its own time.
TrackHistory::Moment moment_of(const TrackWay& way, Utime utime, const TrackModel& model) {
  TrackHistory::Moment moment;
  moment.T_start_body = track_motion(way, model.gauge_m);
  moment.way = way;
  moment.reading.utime = utime;
  moment.chain = 1;
  return moment;
}

TrackStep step_of(const TrackWay& way, const TrackModel& model = {}) {
  return track_step(moment_of({}, kFrom, model), kFrom, moment_of(way, kTo, model), kTo, model)
      .value();
}

Isometry along_x(double x_m) {
  Isometry T = Isometry::Identity();
  T.translation().x() = x_m;
  return T;
}

Belief seen_at(const Isometry& T, double sigma_m, double sigma_rad) {
  Belief belief{T, Matrix6d::Zero()};
  belief.covariance.diagonal().head<3>().setConstant(sigma_m * sigma_m);
  belief.covariance.diagonal().tail<3>().setConstant(sigma_rad * sigma_rad);
  return belief;
}

TEST(TrackStep, IsTheMotionBetweenTwoMoments) {
  const TrackModel model;
  const TrackWay first{0.2, 0.3};
  const TrackWay second{0.25, 0.31};
  const auto step =
      track_step(moment_of(first, kFrom, model), kFrom, moment_of(second, kTo, model), kTo, model);
  ASSERT_TRUE(step);
  const auto expected =
      track_motion(first, model.gauge_m).inverse() * track_motion(second, model.gauge_m);
  EXPECT_TRUE(step->T_from_to.isApprox(in_space(expected), 1e-12));
  EXPECT_NEAR(step->way.left_m, 0.05, 1e-12);
  EXPECT_NEAR(step->way.right_m, 0.01, 1e-12);
  EXPECT_FALSE(step->stands());
  EXPECT_EQ(step->unread_m, 0);
  auto elsewhere = moment_of(second, kTo, model);
  elsewhere.chain = 2;
  EXPECT_FALSE(track_step(moment_of(first, kFrom, model), kFrom, elsewhere, kTo, model));
}

TEST(TrackStep, WhatHappenedAfterTheLastReadingIsReckonedAtFullAcceleration) {
  TrackModel model;
  model.max_acceleration_mps2 = 2;
  auto to = moment_of({0.02, 0.02}, kTo, model);
  to.reading.utime = kTo - 50'000;
  const auto step = track_step(moment_of({}, kFrom, model), kFrom, to, kTo, model);
  ASSERT_TRUE(step);
  EXPECT_NEAR(step->unread_m, 0.5 * 2 * 0.05 * 0.05, 1e-12);
}

TEST(TrackPrior, AloneIsDeadReckoning) {
  const TrackModel model;
  const Belief before = seen_at(along_x(3), 0.001, 0.001);
  const TrackPrior prior(before, step_of({0.02, 0.03}), model);
  EXPECT_TRUE(prior.alone().T_odom_body.isApprox(
      along_x(3) * in_space(track_motion({0.02, 0.03}, model.gauge_m)), 1e-12));
}

// Along one axis fusion is the weighted mean of Gauss.
TEST(TrackPrior, WeighsByInformation) {
  const TrackModel model;
  const TrackWay way{0.02, 0.02};
  const TrackPrior prior({}, step_of(way, model), model);
  const double seen_sigma_m = 0.004;
  const auto both = prior.agreed_with(seen_at(along_x(0.023), seen_sigma_m, 0.001));
  ASSERT_TRUE(both);
  // Slip that lasts over 0.3 m makes a step of 0.02 m count a fifteenth; two tracks halve it.
  const double tracks_variance = 0.15 * 0.15 * 0.02 * 0.02 * (0.3 / 0.02) / 2 + 1e-8;
  const double weight = tracks_variance / (tracks_variance + seen_sigma_m * seen_sigma_m);
  EXPECT_NEAR(both->T_odom_body.translation().x(), 0.02 + weight * 0.003, 1e-6);
  EXPECT_NEAR(both->covariance(0, 0), weight * seen_sigma_m * seen_sigma_m, 1e-9);
}

TEST(TrackPrior, SlipThatLastsAddsUpToThatOfTheWholeWay) {
  const TrackModel model;
  constexpr int kSteps = 30;
  Belief belief;
  for (int i = 0; i < kSteps; ++i)
    belief = TrackPrior(belief, step_of({0.01, 0.01}, model), model).alone();
  const double whole_sigma_m = 0.15 * 0.3 / std::sqrt(2.0);
  EXPECT_NEAR(std::sqrt(belief.covariance(0, 0)), whole_sigma_m, 0.02 * whole_sigma_m);
}

TEST(TrackPrior, TracksThatMoveSayNothingOfHeightRollAndPitch) {
  const TrackModel model;
  const TrackPrior prior({}, step_of({0.02, 0.02}, model), model);
  Isometry up_a_ramp = Isometry::Identity();
  up_a_ramp.translation() = Eigen::Vector3d(0.02, 0, 0.01);
  up_a_ramp.linear() = rotation_from_rpy(0.05, -0.1, 0);
  const auto both = prior.agreed_with(seen_at(up_a_ramp, 0.001, 0.001));
  ASSERT_TRUE(both);
  EXPECT_NEAR(both->T_odom_body.translation().z(), 0.01, 1e-4);
  EXPECT_NEAR(log_so3(both->T_odom_body.linear()).x(), 0.05, 1e-3);
  EXPECT_NEAR(log_so3(both->T_odom_body.linear()).y(), -0.1, 1e-3);
}

TEST(TrackPrior, StandingTracksHoldTheBodyAgainstNoiseButNotAgainstAPush) {
  const TrackModel model;
  const Belief before = seen_at(Isometry::Identity(), 0, 0);
  const TrackPrior prior(before, step_of({}, model), model);
  const auto held = prior.agreed_with(seen_at(along_x(0.001), 0.001, 0.001));
  ASSERT_TRUE(held);
  EXPECT_NEAR(held->T_odom_body.translation().x(), 0.00001, 2e-6);
  EXPECT_FALSE(prior.agreed_with(seen_at(along_x(0.05), 0.001, 0.001)));
}

TEST(TrackPrior, AStartThatTheReadingsDoNotShowYetIsNoContradiction) {
  TrackModel model;
  auto to = moment_of({}, kTo, model);
  to.reading.utime = kTo - 50'000;
  const auto step = track_step(moment_of({}, kFrom, model), kFrom, to, kTo, model);
  const auto both = TrackPrior({}, *step, model).agreed_with(seen_at(along_x(0.003), 0.0003, 1e-3));
  ASSERT_TRUE(both);
  EXPECT_GT(both->T_odom_body.translation().x(), 0.0025);
}

TEST(TrackPrior, ContradictsSightThatIsFarOff) {
  const TrackModel model;
  const TrackPrior prior({}, step_of({0.02, 0.02}, model), model);
  Isometry aside = along_x(0.02);
  aside.translation().y() = 0.03;
  EXPECT_FALSE(prior.agreed_with(seen_at(aside, 0.001, 0.001)));
  EXPECT_TRUE(prior.agreed_with(seen_at(aside, 0.02, 0.01)));
}

}  // namespace
}  // namespace cairn::odometry
