// SPDX-License-Identifier: Apache-2.0
#include "localization/localizer.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <numbers>
#include <string>
#include <vector>

#include "self_mapped_drive.hpp"

namespace cairn::localization {
namespace {

using testing::DriveResult;
using testing::on_floor;

constexpr double kDegree = std::numbers::pi / 180;

void show(const std::string& what, const DriveResult& drive) {
  auto ms = drive.update_ms;
  std::sort(ms.begin(), ms.end());
  std::cout << what << ", " << drive.poses.size() << " frames: odometry rms "
            << DriveResult::rms_m(drive.odometry, drive.truth) << " m, end "
            << DriveResult::end_m(drive.odometry, drive.truth) << " m; pose rms "
            << DriveResult::rms_m(drive.poses, drive.truth) << " m, end "
            << DriveResult::end_m(drive.poses, drive.truth) << " m; update p50 "
            << ms[ms.size() / 2] << " ms, p99 " << ms[ms.size() * 99 / 100] << " ms, most "
            << ms.back() << " ms of CPU\n";
}

DriveResult drive(const testing::OdometryStep& odometry, int laps) {
  return testing::drive_and_map(testing::world_named("room"), testing::room_tour(laps, 0.4),
                                odometry, 0.02, 0.3, 1, {});
}

void expect_always_sure(const DriveResult& drive) {
  for (const Localizer::Pose& pose : drive.published) {
    EXPECT_EQ(pose.certainty, Certainty::kTracking);
  }
  EXPECT_EQ(drive.late, 0);
}

// Acceptance of the localizer: tracks alone, the right one slips by 30 %.
TEST(Localizer, TakesAwaySeventyPercentOfASlippingTracksErrorInAMapOfItsOwn) {
  const DriveResult result = drive(testing::slipping_tracks(0.3), 1);
  show("tracks, 30 % slip on one", result);
  EXPECT_GT(DriveResult::rms_m(result.odometry, result.truth), 0.8);
  EXPECT_LT(DriveResult::rms_m(result.poses, result.truth),
            0.3 * DriveResult::rms_m(result.odometry, result.truth));
  EXPECT_LT(DriveResult::end_m(result.poses, result.truth),
            0.3 * DriveResult::end_m(result.odometry, result.truth));
}

TEST(Localizer, TakesOutTheDriftOfGoodOdometryWhereItHasBeenBefore) {
  const DriveResult result = drive(testing::stereo_like(0.01, 1), 2);
  show("stereo odometry with 1 % drift", result);
  EXPECT_LT(DriveResult::rms_m(result.poses, result.truth),
            0.5 * DriveResult::rms_m(result.odometry, result.truth));
  EXPECT_LT(DriveResult::end_m(result.poses, result.truth), 0.05);
  expect_always_sure(result);
}

TEST(Localizer, DoesNotChaseTheErrorsOfAMapOfItsOwn) {
  const DriveResult result = drive(testing::stereo_like(0, 1), 1);
  show("stereo odometry without drift", result);
  EXPECT_LT(DriveResult::rms_m(result.poses, result.truth), 0.03);
  expect_always_sure(result);
}

/// A room of config/worlds in a finished map, and a robot in it that stands or turns.
class InFinishedMap {
 public:
  InFinishedMap(const std::string& world, const LocalizerConfig& config)
      : eyes_{testing::world_named(world), 0.3, 5}, own_{0.02}, localizer_{config} {
    Utime before = 0;
    for (const auto& [x, y] : {std::pair{-1.2, -1.0}, {1.2, 1.0}, {-1.0, 1.0}, {1.0, -1.0}}) {
      for (int i = 0; i < 24; ++i) {
        const Isometry T = on_floor(x, y, 15 * i * kDegree);
        own_.see(eyes_.look(T, ++before), T);
      }
    }
    own_.tell(before);
  }

  /// One frame, seen from `T`, that odometry believes to have moved by `said` since the one before.
  Localizer::Pose frame(const Isometry& T, const Isometry& said) {
    now_ += 66'667;
    T_odom_body_ = T_odom_body_ * said;
    OdometryFrame odometry;
    odometry.utime = now_;
    odometry.T_odom_body = T_odom_body_;
    odometry.step_covariance.diagonal() << 1e-6, 1e-6, 1e-8, 1e-8, 1e-8, 1e-6;
    const auto pose = localizer_.move(odometry);
    (void)localizer_.update(eyes_.look(T, now_), own_.replica, own_.replica.take_changes());
    T_map_body_ = pose.T_map_odom * T_odom_body_;
    return pose;
  }

  /// Turns on the spot from `T` by so many frames of 4 degrees.
  Certainty turn(Isometry& T, int frames) {
    Certainty last = Certainty::kLost;
    for (int i = 0; i < frames; ++i) {
      T = T * on_floor(0, 0, 4 * kDegree);
      last = frame(T, on_floor(0, 0, 4 * kDegree)).certainty;
      if (last == Certainty::kTracking) {
        wrong_sure_ += off_m(T) > 0.3 ? 1 : 0;
      }
    }
    return last;
  }

  [[nodiscard]] double off_m(const Isometry& T) const {
    return (T_map_body_.translation() - T.translation()).norm();
  }
  [[nodiscard]] double off_rad(const Isometry& T) const {
    return std::abs(std::remainder(yaw_rad(T_map_body_) - yaw_rad(T), 2 * std::numbers::pi));
  }
  [[nodiscard]] int wrong_sure() const { return wrong_sure_; }
  Localizer& localizer() { return localizer_; }

 private:
  testing::NoisyEyes eyes_;
  testing::OwnMap own_;
  Localizer localizer_;
  Utime now_ = 1'000'000'000;
  Isometry T_odom_body_ = Isometry::Identity();
  Isometry T_map_body_ = Isometry::Identity();
  int wrong_sure_ = 0;  ///< frames
};

TEST(Localizer, CarriedAwayItSaysSoAndFindsItselfAgain) {
  for (const int seed : {1, 2, 3}) {
    LocalizerConfig config;
    config.seed = seed;
    InFinishedMap robot("room", config);
    Isometry T = on_floor(-1.2, -1.0, 0);
    robot.localizer().start_at(T, 0.05, 0.05);
    EXPECT_EQ(robot.turn(T, 20), Certainty::kTracking);
    EXPECT_LT(robot.off_m(T), 0.05);
    T = on_floor(1.1, 0.9, 2.5);  // odometry sees nothing of it
    EXPECT_EQ(robot.turn(T, 150), Certainty::kTracking) << seed;
    EXPECT_LT(robot.off_m(T), 0.05) << seed;
    EXPECT_LT(robot.wrong_sure(), 15) << "sure in the wrong place for a second: " << seed;
  }
}

TEST(Localizer, TheSameInputGivesTheSameBytes) {
  std::vector<std::vector<double>> runs;
  for (int run = 0; run < 2; ++run) {
    InFinishedMap robot("room", {});
    robot.localizer().forget();
    std::vector<double> numbers;
    Isometry T = on_floor(-0.8, 0.9, 0.7);
    for (int i = 0; i < 25; ++i) {
      T = T * on_floor(0, 0, 4 * kDegree);
      const auto pose = robot.frame(T, on_floor(0, 0, 4 * kDegree));
      for (const double number : pose.T_map_odom.matrix().reshaped()) numbers.push_back(number);
      for (const double number : pose.covariance.reshaped()) numbers.push_back(number);
    }
    for (const Particle& particle : robot.localizer().filter().particles()) {
      numbers.push_back(particle.x_m);
      numbers.push_back(particle.weight);
    }
    runs.push_back(numbers);
  }
  EXPECT_EQ(runs[0], runs[1]);
}

}  // namespace
}  // namespace cairn::localization
