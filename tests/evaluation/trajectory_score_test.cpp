// SPDX-License-Identifier: Apache-2.0
#include "evaluation/trajectory_score.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

namespace cairn::evaluation {
namespace {

Isometry at(double x_m, double y_m, double yaw = 0) {
  Isometry T = Isometry::Identity();
  T.linear() = rotation_from_rpy(0, 0, yaw);
  T.translation() = Eigen::Vector3d(x_m, y_m, 0);
  return T;
}

/// Pairs at 10 Hz.
std::vector<PosePair> pairs_of(const std::vector<std::pair<Isometry, Isometry>>& estimate_truth) {
  std::vector<PosePair> pairs;
  for (const auto& [estimate, truth] : estimate_truth) {
    pairs.push_back({static_cast<Utime>(pairs.size()) * 100'000, estimate, truth});
  }
  return pairs;
}

/// A curved 3-D way with turning attitude, and an estimate of it that is a little wrong everywhere.
std::vector<PosePair> noisy_way(std::size_t count) {
  std::mt19937 random(11);
  std::normal_distribution<double> noise(0, 0.02);
  std::vector<PosePair> pairs;
  for (std::size_t i = 0; i < count; ++i) {
    const double s = 0.1 * static_cast<double>(i);
    PosePair pair;
    pair.utime = static_cast<Utime>(i) * 100'000;
    pair.truth.linear() = rotation_from_rpy(0.1 * std::sin(s), 0.05 * std::cos(s), 0.3 * s);
    pair.truth.translation() =
        Eigen::Vector3d(3 * std::sin(0.3 * s), 3 - 3 * std::cos(0.3 * s), 0.2 * std::sin(s));
    pair.estimate = pair.truth;
    pair.estimate.translation() += Eigen::Vector3d(noise(random), noise(random), noise(random));
    pair.estimate.linear() *= exp_so3(Eigen::Vector3d(noise(random), noise(random), noise(random)));
    pairs.push_back(pair);
  }
  return pairs;
}

Isometry some_transform() {
  Isometry T = Isometry::Identity();
  T.linear() = rotation_from_rpy(0.7, -0.4, 2.2);
  T.translation() = Eigen::Vector3d(4, -7, 1.5);
  return T;
}

Trajectory stamps(const std::vector<Utime>& utimes) {
  Trajectory poses;
  for (const Utime utime : utimes) poses.push_back({utime, at(static_cast<double>(utime), 0)});
  return poses;
}

TEST(Associate, TakesTheNearestWithinTenMilliseconds) {
  // 0: truth at 4,000. 100,000: truth at 110,000 is just near enough. 200,000: 210,001 is not.
  const auto pairs =
      associate(stamps({0, 100'000, 200'000}), stamps({-9'000, 4'000, 110'000, 210'001}));
  ASSERT_EQ(pairs.size(), 2U);
  EXPECT_EQ(pairs[0].truth.translation().x(), 4'000);
  EXPECT_EQ(pairs[1].utime, 100'000);
  EXPECT_EQ(pairs[1].truth.translation().x(), 110'000);
}

TEST(Associate, UsesEachTrueMomentOnce) {
  // Both estimates lie within 10 ms of the one truth; the nearer has it.
  const auto pairs = associate(stamps({0, 8'000}), stamps({5'000}));
  ASSERT_EQ(pairs.size(), 1U);
  EXPECT_EQ(pairs[0].utime, 8'000);
  EXPECT_TRUE(associate({}, stamps({0})).empty());
  EXPECT_TRUE(associate(stamps({0}), {}).empty());
}

TEST(Statistics, ByHand) {
  // 1, 2, 3, 10: mean 16/4 = 4; median (2+3)/2; rms sqrt((1+4+9+100)/4) = sqrt(28.5).
  const ErrorStatistics s = statistics({3, 1, 10, 2});
  EXPECT_EQ(s.count, 4U);
  EXPECT_DOUBLE_EQ(s.mean, 4);
  EXPECT_DOUBLE_EQ(s.median, 2.5);
  EXPECT_DOUBLE_EQ(s.rmse, std::sqrt(28.5));
  EXPECT_DOUBLE_EQ(s.max, 10);
  EXPECT_DOUBLE_EQ(statistics({5}).median, 5);
}

TEST(Align, LeastSquaresFindsTheTransformThatWasApplied) {
  std::vector<PosePair> pairs = noisy_way(100);
  for (PosePair& pair : pairs) pair.estimate = some_transform().inverse() * pair.truth;
  const Isometry T = align(pairs, Alignment::kLeastSquares);
  EXPECT_LT((T.matrix() - some_transform().matrix()).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_LT(absolute_error_m(pairs, T).max, 1e-9);
}

TEST(Align, LeastSquaresBeatsEveryNeighbouringTransform) {
  const std::vector<PosePair> pairs = noisy_way(100);
  const Isometry best = align(pairs, Alignment::kLeastSquares);
  const double rmse = absolute_error_m(pairs, best).rmse;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double step : {-1e-3, 1e-3}) {
      Isometry moved = best;
      moved.translation()(axis) += step;
      EXPECT_GT(absolute_error_m(pairs, moved).rmse, rmse);
      Isometry turned = best;
      turned.linear() = exp_so3(step * Eigen::Vector3d::Unit(axis)) * best.linear();
      EXPECT_GT(absolute_error_m(pairs, turned).rmse, rmse);
    }
  }
}

TEST(Align, OnAStraightWayTheOrientationsDecideTheRoll) {
  std::vector<PosePair> pairs;
  for (int i = 0; i < 20; ++i) {
    const Isometry truth = at(0.1 * i, 0);
    pairs.push_back({i, some_transform().inverse() * truth, truth});
  }
  const Isometry T = align(pairs, Alignment::kLeastSquares);
  EXPECT_LT((T.matrix() - some_transform().matrix()).cwiseAbs().maxCoeff(), 1e-9);
}

TEST(Align, StandingStillTheOrientationsDecideAll) {
  const Isometry truth = at(1, 2, 0.5);
  const std::vector<PosePair> pairs(5, PosePair{0, some_transform().inverse() * truth, truth});
  const Isometry T = align(pairs, Alignment::kLeastSquares);
  EXPECT_LT((T.matrix() - some_transform().matrix()).cwiseAbs().maxCoeff(), 1e-9);
}

TEST(AlignMaps, TurningOnTheSpotThePositionsNoiseTurnsNothing) {
  std::mt19937 random(5);
  std::normal_distribution<double> noise_m(0, 0.002);
  std::vector<PosePair> pairs;
  for (int i = 0; i < 60; ++i) {
    PosePair pair{i, at(1, 2, 0.1 * i), at(1, 2, 0.1 * i)};
    pair.truth.translation().x() += 0.001 * std::sin(0.1 * i);
    if (i > 0) pair.estimate.translation() += Eigen::Vector3d(noise_m(random), noise_m(random), 0);
    pairs.push_back(pair);
  }
  const Isometry T = align_maps(pairs);
  EXPECT_LT(rotation_angle_rad(T.linear()), 1e-4);
  EXPECT_LT(T.translation().norm(), 0.001);
}

TEST(AlignMaps, OnAnAlmostStraightWayItsWidthTurnsNothing) {
  std::mt19937 random(6);
  std::normal_distribution<double> noise_m(0, 0.003);
  std::vector<PosePair> pairs;
  for (int i = 0; i < 100; ++i) {
    PosePair pair{i, at(0.02 * i, 0.02 * std::sin(0.03 * i)), {}};
    pair.truth = pair.estimate;
    pair.estimate.translation() +=
        Eigen::Vector3d(noise_m(random), noise_m(random), noise_m(random));
    pairs.push_back(pair);
  }
  EXPECT_LT(rotation_angle_rad(align_maps(pairs).linear()), 0.002);
  EXPECT_GT(rotation_angle_rad(align(pairs, Alignment::kLeastSquares).linear()), 0.02)
      << "positions alone would do as well: this asks nothing";
}

TEST(AlignMaps, BeatsEveryNeighbouringTransformInPositionsAndOrientationsTogether) {
  const std::vector<PosePair> pairs = noisy_way(100);
  const auto cost = [&](const Isometry& T) {
    double sum = 0;
    for (const PosePair& pair : pairs) {
      const Isometry off = T * pair.estimate;
      sum += (off.translation() - pair.truth.translation()).squaredNorm() +
             kMapLever_m * kMapLever_m * (off.linear() - pair.truth.linear()).squaredNorm();
    }
    return sum;
  };
  const Isometry best = align_maps(pairs);
  for (int axis = 0; axis < 3; ++axis) {
    for (const double step : {-1e-3, 1e-3}) {
      Isometry moved = best;
      moved.translation()(axis) += step;
      EXPECT_GT(cost(moved), cost(best));
      Isometry turned = best;
      turned.linear() = exp_so3(step * Eigen::Vector3d::Unit(axis)) * best.linear();
      EXPECT_GT(cost(turned), cost(best));
    }
  }
}

TEST(AbsoluteError, ByHand) {
  // A square's corners; the estimate of one of them is off. Truth (0,0) (1,0) (1,1) (0,1); estimate
  // shifted by (5, 0), and the corners alternately 0.1 m outwards along the diagonal and inwards:
  // no better rotation or translation exists by symmetry, so every error is 0.1.
  const double d = 0.1 / std::numbers::sqrt2;
  const auto pairs = pairs_of({{at(5 - d, -d), at(0, 0)},
                               {at(6 - d, d), at(1, 0)},
                               {at(6 + d, 1 + d), at(1, 1)},
                               {at(5 + d, 1 - d), at(0, 1)}});
  const ErrorStatistics ate = absolute_error_m(pairs, align(pairs, Alignment::kLeastSquares));
  EXPECT_NEAR(ate.rmse, 0.1, 1e-12);
  EXPECT_NEAR(ate.mean, 0.1, 1e-12);
  EXPECT_NEAR(ate.max, 0.1, 1e-12);
}

TEST(AbsoluteError, FirstPoseAlignmentByHand) {
  // The estimate is 1 m to the left of the truth and looks 90 degrees to the left. Laid over the
  // first pose, a metre along its own x is a metre along the truth's x: errors 0, 0.1, 0.2.
  const double q = std::numbers::pi / 2;
  const auto pairs =
      pairs_of({{at(0, 1, q), at(0, 0)}, {at(0, 2.1, q), at(1, 0)}, {at(0, 3.2, q), at(2, 0)}});
  const ErrorStatistics ate = absolute_error_m(pairs, align(pairs, Alignment::kFirstPose));
  EXPECT_NEAR(ate.rmse, std::sqrt((0.01 + 0.04) / 3), 1e-12);
  EXPECT_NEAR(ate.median, 0.1, 1e-12);
}

TEST(AbsoluteError, DoesNotDependOnTheFramesOfEither) {
  std::vector<PosePair> pairs = noisy_way(200);
  const double rmse = absolute_error_m(pairs, align(pairs, Alignment::kLeastSquares)).rmse;
  const double first = absolute_error_m(pairs, align(pairs, Alignment::kFirstPose)).rmse;
  EXPECT_GT(rmse, 0.01);
  for (PosePair& pair : pairs) {
    pair.estimate = some_transform() * pair.estimate;
    pair.truth = at(-3, 8, 1) * pair.truth;
  }
  EXPECT_NEAR(absolute_error_m(pairs, align(pairs, Alignment::kLeastSquares)).rmse, rmse, 1e-9);
  EXPECT_NEAR(absolute_error_m(pairs, align(pairs, Alignment::kFirstPose)).rmse, first, 1e-9);
}

TEST(RelativeError, OverDistanceByHand) {
  // Truth steps 0.5 m; the estimate 0.55 m, and its second step also turns by 0.1 rad. Over 1 m
  // (two steps): 0->2: the estimate goes 1.1 straight, and ends turned: 0.1 m, 0.1 rad. 1->3: 0.55
  // straight, then 0.55 at 0.1 rad: error (0.55 + 0.55 cos 0.1 - 1, 0.55 sin 0.1), 0.1 rad. From 2
  // and 3 there is no metre left.
  const double x3 = 1.1 + 0.55 * std::cos(0.1);
  const double y3 = 0.55 * std::sin(0.1);
  const auto pairs = pairs_of({{at(0, 0), at(0, 0)},
                               {at(0.55, 0), at(0.5, 0)},
                               {at(1.1, 0, 0.1), at(1, 0)},
                               {at(x3, y3, 0.1), at(1.5, 0)}});
  const auto rpe = relative_error_over_distance(pairs, 1.0);
  ASSERT_TRUE(rpe);
  EXPECT_EQ(rpe->count, 2U);
  const double ex = x3 - 0.55 - 1;
  EXPECT_NEAR(rpe->translation_rmse_m, std::sqrt((0.01 + ex * ex + y3 * y3) / 2), 1e-12);
  EXPECT_NEAR(rpe->rotation_rmse_rad, 0.1, 1e-12);
  EXPECT_FALSE(relative_error_over_distance(pairs, 1.6));
}

TEST(RelativeError, OverTimeByHand) {
  // 11 pairs over 1 s at 10 Hz, and one more: two pairs a second apart, each 0.2 m off (2 % of 10
  // m).
  std::vector<PosePair> pairs;
  for (int i = 0; i < 12; ++i) pairs.push_back({i * 100'000, at(1.02 * i, 0), at(i, 0)});
  const auto rpe = relative_error_over_time(pairs, 1'000'000);
  ASSERT_TRUE(rpe);
  EXPECT_EQ(rpe->count, 2U);
  EXPECT_NEAR(rpe->translation_rmse_m, 0.2, 1e-12);
  EXPECT_NEAR(rpe->rotation_rmse_rad, 0, 1e-12);
}

TEST(RelativeError, AFrameRateThatDoesNotDivideTheSecondLosesNoFrame) {
  // 15 Hz with times cut to microseconds: frame 15 is at 999,999 or 1,000,000 us.
  std::vector<PosePair> pairs;
  for (int i = 0; i < 16; ++i)
    pairs.push_back({i * std::int64_t{1'000'000} / 15 - (i == 15), at(i, 0), at(i, 0)});
  const auto rpe = relative_error_over_time(pairs, 1'000'000);
  ASSERT_TRUE(rpe);
  EXPECT_EQ(rpe->count, 1U);
}

TEST(Drift, OfAStraightLineScaledByOnePercentIsOnePercent) {
  std::vector<PosePair> pairs;
  for (int i = 0; i <= 10'000; ++i)
    pairs.push_back({i * 100'000, at(0.101 * i, 0), at(0.1 * i, 0)});
  const auto street = drift(pairs, kitti_lengths_m());
  ASSERT_TRUE(street);
  // A sub-sequence ends at the first pose beyond its length: 0.1 m over 100 m is 0.1 % of the 1 %.
  EXPECT_NEAR(street->translation_percent, 1, 0.002);
  EXPECT_NEAR(street->rotation_deg_per_m, 0, 1e-9);
  const auto room = drift(pairs, indoor_lengths_m());
  ASSERT_TRUE(room);
  EXPECT_NEAR(room->translation_percent, 1, 0.1);
}

TEST(Drift, OfAConstantTurnByHand) {
  // The truth goes straight, the estimate turns 0.01 rad per metre on the spot of each step: 0.01
  // rad = 0.57 degrees a metre. Steps are 1/8 m, exact in binary, so the first pair *beyond* a
  // length is one step farther, as in the benchmark's own code: over 2 m 17 steps = 2.125 m.
  std::vector<PosePair> pairs;
  for (int i = 0; i <= 40; ++i) {
    const double s = 0.125 * i;
    pairs.push_back({i, at(s, 0, 0.01 * s), at(s, 0)});
  }
  const std::vector<double> two{2.0};
  const auto d = drift(pairs, two);
  ASSERT_TRUE(d);
  EXPECT_EQ(d->count, 3U);  // starts 0, 10, 20 of 40; 30 + 17 is beyond the end
  EXPECT_NEAR(d->rotation_deg_per_m, 0.01 * 2.125 / 2 * 180 / std::numbers::pi, 1e-9);
}

TEST(Drift, AWayThatIsTooShortHasNone) {
  const auto pairs = pairs_of({{at(0, 0), at(0, 0)}, {at(1, 0), at(1, 0)}});
  EXPECT_FALSE(drift(pairs, kitti_lengths_m()));
}

TEST(EndError, ByHand) {
  // True way 3 + 4 = 7 m, ends at (3, 4). The estimate, in a frame of its own turned by 90 degrees,
  // ends at (3.3, 4.4) of the truth's frame, looking 0.2 rad too far to the right: off by 0.5 m =
  // 1/14 of the way.
  const Isometry frame = at(10, -2, std::numbers::pi / 2);
  const auto pairs = pairs_of({{frame * at(0, 0), at(0, 0)},
                               {frame * at(3, 0), at(3, 0)},
                               {frame * at(3.3, 4.4, 1.3), at(3, 4, 1.5)}});
  const EndError end = end_error(pairs);
  EXPECT_NEAR(end.position_m, 0.5, 1e-12);
  EXPECT_NEAR(*end.fraction_of_way, 0.5 / 7, 1e-12);
  EXPECT_NEAR(end.yaw_rad, -0.2, 1e-12);
  EXPECT_FALSE(end_error(std::span(pairs).first(1)).fraction_of_way);
}

TEST(ScoreTrajectory, OfThePerfectEstimateIsZero) {
  Trajectory truth;
  for (const PosePair& pair : noisy_way(100)) truth.push_back({pair.utime, pair.truth});
  const auto score = score_trajectory(truth, truth);
  ASSERT_TRUE(score);
  EXPECT_EQ(score->pairs, 100U);
  EXPECT_NEAR(score->length_m, path_length_m(truth), 1e-12);
  EXPECT_NEAR(score->duration_s, 9.9, 1e-12);
  EXPECT_LT(score->ate_m.max, 1e-9);
  EXPECT_LT(score->ate_first_pose_m.max, 1e-9);
  EXPECT_LT(score->rpe_1m->translation_rmse_m, 1e-9);
  EXPECT_LT(score->rpe_1s->rotation_rmse_rad, 1e-9);
  EXPECT_LT(score->drift_indoor->translation_percent, 1e-6);
  EXPECT_FALSE(score->drift_kitti);
  EXPECT_LT(score->end.position_m, 1e-9);
}

TEST(ScoreTrajectory, RefusesTrajectoriesThatShareNoTime) {
  const auto score = score_trajectory(stamps({0, 100'000}), stamps({50'000, 1'000'000}));
  ASSERT_FALSE(score);
  EXPECT_EQ(score.error().message,
            "trajectories of 2 and 2 poses share 0 moments (within 10 ms); 2 are needed");
}

}  // namespace
}  // namespace cairn::evaluation
