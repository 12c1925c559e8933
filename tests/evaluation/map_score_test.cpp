// SPDX-License-Identifier: Apache-2.0
#include "evaluation/map_score.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace cairn::evaluation {
namespace {

using Points = std::vector<Eigen::Vector3d>;

/// A wall that fills x > 0; its surface was seen at y = 0 to 9 cm, one sample per centimetre, z =
/// 0.
MapTruth wall() {
  MapTruth truth;
  truth.distance_m = [](const Eigen::Vector3d& p) { return -p.x(); };
  for (int i = 0; i < 10; ++i)
    truth.observable_surface.emplace_back(0.001, 0.01 * i + 0.005, 0.005);
  return truth;
}

Eigen::Vector3d voxel(int x, int y) { return {0.01 * x + 0.005, 0.01 * y + 0.005, 0.005}; }

TEST(ScoreMap, ByHand) {
  // Occupied: four voxels on the surface (x = 0, y = 0 to 3), one 2.5 cm in front (x = -3):
  // precision 4/5. Within 2 cm of an occupied voxel lie the samples y = 0 to 3, and 4: its distance
  // to voxel (0, 3) is sqrt(0.004^2 + 0.01^2) = 1.1 cm; 5 is 2.04 cm away. Recall 5/10, so 5 voxels
  // are missed: iou 4 / (4 + 1 + 5).
  const Points occupied{voxel(0, 0), voxel(0, 1), voxel(0, 2), voxel(0, 3), voxel(-3, 0)};
  // Free: x = -1 lies 0.5 cm in front (not nearer than half a voxel), x = 0 in the wall by 0.5, x =
  // 5 deep in it.
  const Points free{voxel(-2, 0), voxel(-10, 0), voxel(0, 9), voxel(5, 9)};
  const MapScore score = score_map(wall(), {0.01, 0.02}, occupied, free);
  EXPECT_DOUBLE_EQ(*score.precision, 4.0 / 5);
  EXPECT_DOUBLE_EQ(*score.recall, 5.0 / 10);
  EXPECT_DOUBLE_EQ(*score.iou, 4.0 / 10);
  EXPECT_DOUBLE_EQ(*score.false_free_rate, 2.0 / 4);
  EXPECT_EQ(score.occupied_voxels, 5U);
  EXPECT_EQ(score.free_voxels, 4U);
}

TEST(ScoreMap, OfNothingIsNotKnown) {
  const MapScore score = score_map(wall(), {0.01, 0.02}, {}, {});
  EXPECT_FALSE(score.precision);
  EXPECT_FALSE(score.false_free_rate);
  EXPECT_EQ(*score.recall, 0);
  EXPECT_EQ(*score.iou, 0);
}

TEST(ScoreMap, ACoarseVoxelCountsForItsSurfaceAndHasHalfItsExtentMoreOfTolerance) {
  const MapTruth truth = wall();
  MapScorer scorer(truth, {0.01, 0.02});
  // 4 cm: tolerance 2 + 1.5 cm. At x = -3.4 cm it is right and counts 16; at -3.6 wrong.
  scorer.add_occupied({{-0.034, 0, 0}, 0.04});
  scorer.add_occupied({{-0.036, 1, 0}, 0.04});
  scorer.add_occupied({voxel(0, 100), 0.01});
  EXPECT_DOUBLE_EQ(*scorer.score().precision, 17.0 / 33);
}

TEST(ScoreMap, ACoarseFreeVoxelCountsAsItsParts) {
  const MapTruth truth = wall();
  MapScorer scorer(truth, {0.01, 0.02});
  // 4 cm cube centred on the surface: its 64 parts stand at x = -1.5, -0.5, 0.5 and 1.5 cm; the
  // first two quarters are not nearer than half a voxel, the other two lie in the wall.
  scorer.add_free({{-1e-9, 0, 0}, 0.04});
  EXPECT_EQ(scorer.score().free_voxels, 64U);
  EXPECT_DOUBLE_EQ(*scorer.score().false_free_rate, 0.5);
  scorer.add_free({{-1, 0, 0}, 0.08});
  EXPECT_DOUBLE_EQ(*scorer.score().false_free_rate, 32.0 / (64 + 512));
}

TEST(ScoreMap, TruthFromSamplesAgreesWithTheClosedForm) {
  MapTruth sampled = wall();
  Points surface;
  for (int y = -20; y < 40; ++y) {
    for (int z = -20; z < 20; ++z) surface.emplace_back(0, 0.005 * y, 0.005 * z);
  }
  sampled.distance_m = distance_to_samples(surface, 0.05);
  const Points occupied{voxel(0, 0), voxel(0, 1), voxel(0, 2), voxel(0, 3), voxel(-3, 0)};
  const Points free{voxel(-2, 0), voxel(-10, 0)};
  const MapScore score = score_map(sampled, {0.01, 0.02}, occupied, free);
  EXPECT_DOUBLE_EQ(*score.precision, 4.0 / 5);
  EXPECT_DOUBLE_EQ(*score.false_free_rate, 0);
}

TEST(DistanceToSamples, AgreesWithBruteForce) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> metres(-0.3, 0.3);
  Points samples;
  for (int i = 0; i < 500; ++i)
    samples.emplace_back(metres(random), metres(random), metres(random));
  const DistanceFunction distance_m = distance_to_samples(samples, 0.07);
  for (int i = 0; i < 500; ++i) {
    const Eigen::Vector3d p(metres(random), metres(random), metres(random));
    double nearest = 0.07;
    for (const Eigen::Vector3d& s : samples) nearest = std::min(nearest, (s - p).norm());
    EXPECT_NEAR(distance_m(p), nearest, 1e-12);
  }
}

}  // namespace
}  // namespace cairn::evaluation
