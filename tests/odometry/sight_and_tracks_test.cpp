// SPDX-License-Identifier: Apache-2.0
// Eyes and tracks together, in a rendered room.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <map>
#include <vector>

#include "odometry/made_tracks.hpp"
#include "odometry/rendered_room.hpp"
#include "odometry/stereo_odometry.hpp"

namespace cairn::odometry {
namespace {

using testing::MadeTracks;
using testing::RenderedRoom;
using testing::robot_camera;
using testing::steady_tracks;

constexpr Utime kFrame_us = 66'667;
constexpr double kSpeed_mps = 0.3;
constexpr double kTurn_radps = 0.3;
constexpr std::size_t kFrames = 75;

Utime time_of(std::size_t i) { return 1'000'000 + static_cast<Utime>(i) * kFrame_us; }

/// The body on its way round a circle, since frame 0.
Isometry true_pose(std::size_t i) {
  const double seconds = to_seconds(time_of(i) - time_of(0));
  return in_space(
      track_motion(steady_tracks(kSpeed_mps, kTurn_radps)(seconds), RobotConfig{}.track_gauge_m));
}

Isometry in_room(const Isometry& T) { return Eigen::Translation3d(-1.5, -0.5, 0) * T; }

struct Pair {
  cv::Mat left;
  cv::Mat right;
};

Pair seen_from(const Isometry& T_room_body, std::uint64_t seed,
               const testing::Panel* panel = nullptr) {
  return {testing::with_noise(RenderedRoom::left(robot_camera(), T_room_body, panel), 2, 2 * seed),
          testing::with_noise(RenderedRoom::right(robot_camera(), T_room_body, panel), 2,
                              2 * seed + 1)};
}

/// Rendered once.
const Pair& drive(std::size_t i) {
  static std::map<std::size_t, Pair> pairs;
  const auto known = pairs.find(i);
  if (known != pairs.end()) return known->second;
  return pairs[i] = seen_from(in_room(true_pose(i)), i);
}

const Pair& dark() {
  static const Pair pair{cv::Mat::zeros(480, 640, CV_8UC1), cv::Mat::zeros(480, 640, CV_8UC1)};
  return pair;
}

OdometryEstimate look(StereoOdometry& odometry, const Pair& pair, std::size_t i,
                      const StereoOdometry::Tracks& tracks) {
  const auto estimate = odometry.update(pair.left, pair.right, robot_camera(), time_of(i), tracks);
  EXPECT_TRUE(estimate) << (estimate ? "" : estimate.error().message);
  EXPECT_TRUE(estimate->T_odom_body.matrix().allFinite());
  EXPECT_TRUE(estimate->step_covariance.allFinite());
  EXPECT_TRUE(estimate->twist.allFinite());
  return *estimate;
}

double off_m(const OdometryEstimate& estimate, const Isometry& truth) {
  return (estimate.T_odom_body.translation() - truth.translation()).norm();
}

double off_rad(const OdometryEstimate& estimate, const Isometry& truth) {
  return rotation_angle_rad(truth.linear().transpose() * estimate.T_odom_body.linear());
}

/// Mean distance from the truth over the drive of 5 s.
double mean_off_m(MadeTracks* tracks, std::map<Dispute, int>* disputes = nullptr) {
  StereoOdometry odometry{StereoOdometryConfig{}};
  double sum_m = 0;
  for (std::size_t i = 0; i < kFrames; ++i) {
    const auto estimate =
        look(odometry, drive(i), i, tracks ? tracks->at(time_of(i)) : std::nullopt);
    sum_m += off_m(estimate, true_pose(i));
    if (disputes != nullptr) ++(*disputes)[estimate.dispute];
  }
  return sum_m / static_cast<double>(kFrames);
}

TEST(SightAndTracks, TracksThatSlipByAThirdCostGoodSightNothing) {
  const double by_sight_m = mean_off_m(nullptr);
  for (const auto& [left, right] : {std::pair{0.3, 0.0}, {-0.3, 0.0}, {0.0, 0.3}, {0.0, 0.0}}) {
    MadeTracks tracks{steady_tracks(kSpeed_mps, kTurn_radps, left, right)};
    std::map<Dispute, int> disputes;
    const double with_tracks_m = mean_off_m(&tracks, &disputes);
    std::printf("slip %4.1f, %4.1f: %.2f mm off in the mean, by sight alone %.2f; %d disputes\n",
                left, right, 1000 * with_tracks_m, 1000 * by_sight_m,
                static_cast<int>(kFrames) - disputes[Dispute::kNone]);
    EXPECT_LE(with_tracks_m, 1.1 * by_sight_m);
  }
}

TEST(SightAndTracks, TracksThatDoNotTurnOrDoNotCountCostGoodSightNothing) {
  const double by_sight_m = mean_off_m(nullptr);
  for (const auto& [left, right] : {std::pair{-1.0, -1.0}, {-1.0, 0.0}, {2.0, 2.0}}) {
    MadeTracks tracks{steady_tracks(kSpeed_mps, kTurn_radps, left, right)};
    std::map<Dispute, int> disputes;
    const double with_tracks_m = mean_off_m(&tracks, &disputes);
    std::printf("slip %4.1f, %4.1f: %.2f mm off in the mean, by sight alone %.2f; %d disputes\n",
                left, right, 1000 * with_tracks_m, 1000 * by_sight_m,
                static_cast<int>(kFrames) - disputes[Dispute::kNone]);
    EXPECT_LE(with_tracks_m, 1.1 * by_sight_m);
    EXPECT_EQ(disputes[Dispute::kSightOverruled], 0);
    EXPECT_EQ(disputes[Dispute::kMoverLeftOut], 0);
  }
}

TEST(SightAndTracks, ThreeSecondsInTheDarkTheTracksCarryOnAsWellAsTheyGrip) {
  constexpr double kSlip = 0.15;  // one sigma of the model, all the time
  MadeTracks tracks{steady_tracks(kSpeed_mps, kTurn_radps, kSlip, 0)};
  StereoOdometry odometry{StereoOdometryConfig{}};
  constexpr std::size_t kDark = 10;
  constexpr std::size_t kLight = kDark + 45;
  Isometry expected = Isometry::Identity();
  std::optional<TrackHistory::Moment> before;
  double variance = 0;
  OdometryEstimate estimate;
  for (std::size_t i = 0; i < kLight + 10; ++i) {
    const bool is_dark = i >= kDark && i < kLight;
    const auto moment = tracks.at(time_of(i));
    const Isometry last = estimate.T_odom_body;
    estimate = look(odometry, is_dark ? dark() : drive(i), i, moment);
    if (is_dark) {
      // Closed form: where sight ended, and the arc that the encoders tell of.
      expected = last * in_space(before->T_start_body.inverse() * moment->T_start_body);
      EXPECT_LT(off_m(estimate, expected), 1e-9);
      EXPECT_EQ(estimate.basis, Basis::kTracks);
      EXPECT_EQ(estimate.dispute, Dispute::kNone);
      EXPECT_FALSE(estimate.coasting);
      EXPECT_GT(estimate.quality, 0);
      EXPECT_LE(estimate.quality, 0.3);
      EXPECT_NEAR(estimate.twist[0], kSpeed_mps, 0.06);
      const double step_m = kSpeed_mps * to_seconds(kFrame_us);
      EXPECT_GT(std::sqrt(estimate.step_covariance(0, 0)), 0.08 * step_m);
      EXPECT_LT(std::sqrt(estimate.step_covariance(0, 0)), 0.2 * step_m);
      variance += estimate.step_covariance(5, 5);
    }
    before = moment;
    if (i + 1 == kLight) {
      const double way_m = kSpeed_mps * 3;
      const double slip_turn_rad =
          kSlip * (kSpeed_mps - kTurn_radps * 0.13) / 0.26 * 3;  // of the left track over 3 s
      std::printf("3 s in the dark, %.2f m, slip 15 %% left: %.3f m and %.2f degrees off\n", way_m,
                  off_m(estimate, true_pose(i)), off_rad(estimate, true_pose(i)) * 180 / M_PI);
      EXPECT_NEAR(off_rad(estimate, true_pose(i)), slip_turn_rad, 0.1 * slip_turn_rad);
      // Half the slip along the way, and half the turn that it makes across.
      EXPECT_LT(off_m(estimate, true_pose(i)), way_m * (kSlip / 2 + slip_turn_rad / 2));
    }
  }
  EXPECT_EQ(estimate.basis, Basis::kBoth);
  EXPECT_GT(estimate.quality, 0.9);
  EXPECT_EQ(estimate.epoch, 0U);
}

TEST(SightAndTracks, ADarkSpellThatEndsInViewOfTheKeyframeLeavesNoErrorBehind) {
  MadeTracks tracks{steady_tracks(kSpeed_mps, kTurn_radps, 0.15, 0)};
  StereoOdometry odometry{StereoOdometryConfig{}};
  OdometryEstimate estimate;
  for (std::size_t i = 0; i < 20; ++i) {
    const bool is_dark = i >= 10 && i < 13;
    estimate = look(odometry, is_dark ? dark() : drive(i), i, tracks.at(time_of(i)));
    if (i > 0) {
      EXPECT_EQ(estimate.basis, is_dark ? Basis::kTracks : Basis::kBoth) << i;
    }
  }
  EXPECT_LT(off_m(estimate, true_pose(19)), 0.005);
}

TEST(SightAndTracks, StandsStillerThanBySightAloneAndSeesAPushAtOnce) {
  MadeTracks tracks{steady_tracks(0, 0)};
  StereoOdometry alone{StereoOdometryConfig{}};
  StereoOdometry both{StereoOdometryConfig{}};
  double farthest_alone_m = 0;
  double farthest_m = 0;
  const Pair& view = drive(0);
  for (std::size_t i = 0; i < 40; ++i) {
    const auto seed = static_cast<std::uint64_t>(1000 + 2 * i);
    const Pair noisy{testing::with_noise(view.left, 3, seed),
                     testing::with_noise(view.right, 3, seed + 1)};
    farthest_alone_m = std::max(farthest_alone_m, off_m(look(alone, noisy, i, {}), true_pose(0)));
    const auto estimate = look(both, noisy, i, tracks.at(time_of(i)));
    farthest_m = std::max(farthest_m, off_m(estimate, true_pose(0)));
    EXPECT_EQ(estimate.dispute, Dispute::kNone) << i;
  }
  std::printf("40 frames at rest: at most %.3f mm off, by sight alone %.3f\n", 1000 * farthest_m,
              1000 * farthest_alone_m);
  EXPECT_LT(farthest_m, farthest_alone_m);
  EXPECT_LT(farthest_m, 0.0005);

  Isometry pushed = Isometry::Identity();
  pushed.translation() = Eigen::Vector3d(0.03, 0.04, 0);
  const Pair after = seen_from(in_room(pushed), 77);
  for (std::size_t i = 40; i < 44; ++i) {
    const auto estimate = look(both, after, i, tracks.at(time_of(i)));
    EXPECT_LT(off_m(estimate, pushed), 0.002) << i;
    EXPECT_EQ(estimate.dispute, i == 40 ? Dispute::kTracksOverruled : Dispute::kNone) << i;
  }
}

/// A board as large as a person at 1.2 m, from the left edge of the view to the middle and beyond,
/// that moves to the right.
testing::Panel passer_by(std::size_t i, double width_m) {
  testing::Panel panel;
  panel.width_m = width_m;
  panel.height_m = 2;
  panel.T_room_panel.translation() =
      in_room(Isometry::Identity()) *
      Eigen::Vector3d(1.35, 0.3 - 0.5 * to_seconds(time_of(i) - time_of(0)), 0.3);
  return panel;
}

/// Somebody walks by, past nine tenths of all that there is to follow, and on to the right.
void expect_not_carried(double speed_mps, double allowed_m) {
  MadeTracks tracks{steady_tracks(speed_mps, 0)};
  StereoOdometry alone{StereoOdometryConfig{}};
  StereoOdometry both{StereoOdometryConfig{}};
  double farthest_alone_m = 0;
  double farthest_m = 0;
  std::map<Dispute, int> disputes;
  OdometryEstimate estimate;
  for (std::size_t i = 0; i < 33; ++i) {
    Isometry truth = Isometry::Identity();
    truth.translation().x() = speed_mps * to_seconds(time_of(i) - time_of(0));
    auto panel = passer_by(i, 1.0);
    panel.T_room_panel.translation().x() += truth.translation().x();
    const Pair pair = seen_from(in_room(truth), i, &panel);
    farthest_alone_m = std::max(farthest_alone_m, off_m(look(alone, pair, i, {}), truth));
    estimate = look(both, pair, i, tracks.at(time_of(i)));
    farthest_m = std::max(farthest_m, off_m(estimate, truth));
    ++disputes[estimate.dispute];
  }
  std::printf(
      "somebody walks by at 0.5 m/s, robot drives at %.1f: %.1f mm off, by sight alone %.1f; in %d "
      "of 33 frames the mover was left out, in %d sight overruled\n",
      speed_mps, 1000 * farthest_m, 1000 * farthest_alone_m, disputes[Dispute::kMoverLeftOut],
      disputes[Dispute::kSightOverruled]);
  EXPECT_GT(farthest_alone_m, 0.1) << "the case is too easy to show anything";
  EXPECT_LT(farthest_m, allowed_m);
  EXPECT_EQ(disputes[Dispute::kTracksOverruled], 0);
  EXPECT_EQ(estimate.basis, Basis::kBoth);
  EXPECT_EQ(estimate.dispute, Dispute::kNone);
}

TEST(SightAndTracks, WhoWalksByDoesNotCarryARobotThatStands) { expect_not_carried(0, 0.001); }

TEST(SightAndTracks, WhoWalksByDoesNotCarryARobotThatDrives) {
  expect_not_carried(kSpeed_mps, 0.02);
}

TEST(SightAndTracks, ARestartBridgesTheGapByTicks) {
  MadeTracks tracks{steady_tracks(kSpeed_mps, kTurn_radps)};
  StereoOdometry first{StereoOdometryConfig{}};
  for (std::size_t i = 0; i < 12; ++i) look(first, drive(i), i, tracks.at(time_of(i)));
  const auto kept = checkpoint_from_bytes(to_bytes(first.checkpoint()));
  ASSERT_TRUE(kept && kept->tracks);

  // Two seconds on, in the new process: the reading that it remembers, and those that it hears.
  TrackHistory heard{RobotConfig{}, TrackConfig{}};
  heard.add(*kept->tracks);
  StereoOdometry second{StereoOdometryConfig{}};
  second.resume(*kept, heard.at(kept->utime));
  constexpr std::size_t kAgain = 42;
  heard.add(tracks.reading(time_of(kAgain) - time_of(kAgain) % 20'000 - 60'000));
  heard.add(tracks.reading(time_of(kAgain) - time_of(kAgain) % 20'000 - 40'000));
  const auto placed = look(second, drive(kAgain), kAgain, heard.at(time_of(kAgain)));
  EXPECT_EQ(placed.epoch, 1U);
  EXPECT_EQ(placed.basis, Basis::kTracks);
  EXPECT_FALSE(placed.coasting);
  EXPECT_LT(off_m(placed, true_pose(kAgain)), 0.01);
  EXPECT_GT(std::sqrt(placed.step_covariance(0, 0)), 0.03) << "nobody saw that way";
}

TEST(SightAndTracks, GivesTheSameBytesAgain) {
  std::vector<OdometryEstimate> runs[2];
  for (auto& run : runs) {
    MadeTracks tracks{steady_tracks(kSpeed_mps, kTurn_radps, 0.1, -0.2)};
    StereoOdometry odometry{StereoOdometryConfig{}};
    for (std::size_t i = 0; i < 10; ++i)
      run.push_back(look(odometry, drive(i), i, tracks.at(time_of(i))));
  }
  for (std::size_t i = 0; i < runs[0].size(); ++i) {
    EXPECT_EQ(runs[0][i].T_odom_body.matrix(), runs[1][i].T_odom_body.matrix());
    EXPECT_EQ(runs[0][i].step_covariance, runs[1][i].step_covariance);
  }
}

}  // namespace
}  // namespace cairn::odometry
