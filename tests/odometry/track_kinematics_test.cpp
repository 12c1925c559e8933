// SPDX-License-Identifier: Apache-2.0
#include "odometry/track_kinematics.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "odometry/made_tracks.hpp"

namespace cairn::odometry {
namespace {

using testing::MadeTracks;
using testing::steady_tracks;

constexpr double kGauge_m = 0.26;

TEST(TrackMotion, IsTheArcAboutTheTracksCentre) {
  const double radius_m = 0.7;
  const double turn_rad = 1.1;
  const auto T = track_motion(
      {(radius_m - kGauge_m / 2) * turn_rad, (radius_m + kGauge_m / 2) * turn_rad}, kGauge_m);
  EXPECT_NEAR(T.translation().x(), radius_m * std::sin(turn_rad), 1e-12);
  EXPECT_NEAR(T.translation().y(), radius_m * (1 - std::cos(turn_rad)), 1e-12);
  EXPECT_NEAR(Eigen::Rotation2Dd(T.linear()).angle(), turn_rad, 1e-12);
  const auto straight = track_motion({0.4, 0.4}, kGauge_m);
  EXPECT_NEAR((straight.translation() - Eigen::Vector2d(0.4, 0)).norm(), 0, 1e-12);
}

TEST(TrackCovariance, IsThatOfTracksThatSlip) {
  const TrackWay way{0.03, 0.045};
  constexpr double kSlip = 0.05;
  constexpr unsigned kSeed = 5;
  std::mt19937 random(kSeed);
  std::normal_distribution<double> slip(0, kSlip);
  const auto mean = track_motion(way, kGauge_m);
  constexpr int kDraws = 200'000;
  Eigen::Matrix2d sum = Eigen::Matrix2d::Zero();
  for (int i = 0; i < kDraws; ++i) {
    const auto drawn =
        track_motion({way.left_m * (1 + slip(random)), way.right_m * (1 + slip(random))}, kGauge_m);
    const auto error = mean.inverse() * drawn;
    const Eigen::Vector2d e(error.translation().x(), Eigen::Rotation2Dd(error.linear()).angle());
    sum += e * e.transpose() / kDraws;
  }
  const Matrix6d covariance = track_covariance(way, kGauge_m, kSlip);
  EXPECT_NEAR(covariance(0, 0) / sum(0, 0), 1, 0.02);
  EXPECT_NEAR(covariance(5, 5) / sum(1, 1), 1, 0.02);
  EXPECT_NEAR(covariance(0, 5) / sum(0, 1), 1, 0.05);
}

/// Readings of the steady drive at multiples of 20 ms up to `last`.
TrackHistory history_of(const MadeTracks& tracks, Utime first, Utime last) {
  TrackHistory history{RobotConfig{}, TrackConfig{}};
  for (Utime utime = first; utime <= last; utime += 20'000) history.add(tracks.reading(utime));
  return history;
}

TEST(TrackHistory, GoesOnAtTheSpeedsOfTheLastReadingThatCounts) {
  const MadeTracks tracks{steady_tracks(0.3, 0.5)};
  const auto history = history_of(tracks, 1'000'000, 2'000'000);
  for (const Utime utime : {1'500'000, 1'507'001, 1'539'999, 2'040'000}) {
    const auto moment = history.at(utime);
    ASSERT_TRUE(moment) << utime;
    const double seconds = to_seconds(utime - 1'000'000);
    const auto expected = track_motion(
        {(0.3 - 0.5 * kGauge_m / 2) * seconds, (0.3 + 0.5 * kGauge_m / 2) * seconds}, kGauge_m);
    EXPECT_LT((moment->T_start_body.translation() - expected.translation()).norm(), 0.0005);
    EXPECT_LE(moment->reading.utime, utime - TrackHistory::kLag_us);
    EXPECT_GT(moment->reading.utime, utime - TrackHistory::kLag_us - 20'000);
  }
}

TEST(TrackHistory, WhatComesLaterDoesNotCount) {
  const MadeTracks tracks{steady_tracks(0.3, 0.5)};
  const auto early = history_of(tracks, 1'000'000, 1'460'000).at(1'500'000);
  const auto late = history_of(tracks, 1'000'000, 3'000'000).at(1'500'000);
  ASSERT_TRUE(early && late);
  EXPECT_EQ(early->T_start_body.matrix(), late->T_start_body.matrix());
  EXPECT_EQ(early->way.left_m, late->way.left_m);
}

TEST(TrackHistory, WaitsForReadingsByDataTimeAndNotForASilentMotor) {
  const MadeTracks tracks{steady_tracks(0.3, 0.5)};
  TrackHistory none{RobotConfig{}, TrackConfig{}};
  EXPECT_TRUE(none.ready_for(1'000'000, 0));
  const auto history = history_of(tracks, 1'000'000, 2'000'000);
  EXPECT_TRUE(history.ready_for(2'040'000, 2'040'000));
  EXPECT_FALSE(history.ready_for(2'040'001, 2'040'001));
  EXPECT_FALSE(history.ready_for(2'050'000, 2'200'000));
  EXPECT_TRUE(history.ready_for(2'050'000, 2'200'001));
  EXPECT_TRUE(history.ready_for(2'300'000, 0)) << "the frame itself says that time went on";
  auto remembered = history;
  remembered.listens_from(2'900'000);
  EXPECT_FALSE(remembered.ready_for(2'950'000, 3'100'000)) << "nobody listened";
  EXPECT_TRUE(remembered.ready_for(2'950'000, 3'100'001));
}

TEST(TrackHistory, ASilentMotorSaysNothing) {
  const MadeTracks tracks{steady_tracks(0.3, 0.5)};
  const auto history = history_of(tracks, 1'000'000, 2'000'000);
  EXPECT_FALSE(history.at(1'030'000));
  EXPECT_TRUE(history.at(2'240'000));
  EXPECT_FALSE(history.at(2'240'001));
}

TEST(TrackHistory, TicksBridgeASilence) {
  const MadeTracks tracks{steady_tracks(0.3, 0.5)};
  auto history = history_of(tracks, 1'000'000, 2'000'000);
  EXPECT_EQ(history.add(tracks.reading(4'000'000)), TrackHistory::Added::kOn);
  const auto before = history.at(2'040'000);
  const auto after = history.at(4'040'000);
  ASSERT_TRUE(before && after);
  EXPECT_EQ(before->chain, after->chain);
  EXPECT_NEAR(after->way.left_m - before->way.left_m, 2 * (0.3 - 0.5 * kGauge_m / 2), 0.001);
  EXPECT_EQ(history.add(tracks.reading(9'000'001)), TrackHistory::Added::kAfresh);
}

TEST(TrackHistory, AControllerThatStartsAnewBreaksTheChain) {
  const MadeTracks tracks{steady_tracks(0.3, 0.5)};
  auto history = history_of(tracks, 1'000'000, 2'000'000);
  const auto before = history.newest();
  TrackReading anew = tracks.reading(2'020'000);
  anew.left_ticks = anew.right_ticks = 0;
  EXPECT_EQ(history.add(anew), TrackHistory::Added::kAfresh);
  EXPECT_NE(history.newest()->chain, before->chain);
  anew.utime += 20'000;
  EXPECT_EQ(history.add(anew), TrackHistory::Added::kOn);
}

// Whatever arrives, in whatever order: finite, and a later reading puts it right.
TEST(TrackHistory, NoReadingMakesItWild) {
  const MadeTracks tracks{steady_tracks(0.3, 0.5)};
  constexpr unsigned kSeed = 17;
  std::mt19937_64 random(kSeed);
  TrackHistory history{RobotConfig{}, TrackConfig{}};
  const double speeds[] = {0, 0.3, -5, 1e300, -1e300, std::numeric_limits<double>::denorm_min()};
  const double scales[] = {5000, 5000, 5000, 1e-300, 1e300};
  for (int i = 0; i < 2000; ++i) {
    TrackReading reading = tracks.reading(1'000'000 + 20'000 * i);
    switch (random() % 6) {
      case 0:
        reading.left_ticks = static_cast<std::int64_t>(random());
        break;
      case 1:
        reading.right_mps = speeds[random() % std::size(speeds)];
        break;
      case 2:
        reading.utime = static_cast<Utime>(random() >> 1);
        break;
      case 3:
        reading.ticks_per_m = scales[random() % std::size(scales)];
        break;
      default:
        break;
    }
    history.add(reading);
    for (const Utime utime : {Utime{1'000'000} + 20'000 * i, reading.utime}) {
      const auto moment = history.at(utime);
      if (!moment) continue;
      ASSERT_TRUE(moment->T_start_body.matrix().allFinite()) << kSeed << " " << i;
      ASSERT_TRUE(std::isfinite(moment->way.left_m) && std::isfinite(moment->way.right_m));
    }
  }
  for (Utime utime = 100'000'000; utime <= 101'000'000; utime += 20'000)
    history.add(tracks.reading(utime));
  const auto from = history.at(100'500'000);
  const auto to = history.at(101'000'000);
  ASSERT_TRUE(from && to);
  EXPECT_NEAR(to->way.left_m - from->way.left_m, 0.5 * (0.3 - 0.5 * kGauge_m / 2), 0.001);
}

}  // namespace
}  // namespace cairn::odometry
