// SPDX-License-Identifier: Apache-2.0
#include "localization/resampling.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <map>

namespace cairn::localization {
namespace {

std::vector<Particle> weighted(const std::vector<double>& weights) {
  std::vector<Particle> particles;
  for (const double weight : weights) {
    Particle particle;
    particle.x_m = static_cast<double>(particles.size());
    particle.weight = weight;
    particles.push_back(particle);
  }
  return particles;
}

TEST(Resampling, TheEffectiveCountIsTheClosedForm) {
  EXPECT_DOUBLE_EQ(effective_count(weighted({0.25, 0.25, 0.25, 0.25})), 4);
  EXPECT_DOUBLE_EQ(effective_count(weighted({1, 0, 0})), 1);
  EXPECT_DOUBLE_EQ(effective_count(weighted({0.5, 0.5, 0})), 2);
}

TEST(Resampling, SystematicDrawsEachFloorOrCeilOfItsShare) {
  RandomSource random(7);
  std::vector<double> weights;
  double sum = 0;
  for (int i = 0; i < 50; ++i) {
    weights.push_back(random.uniform() * random.uniform());
    sum += weights.back();
  }
  for (double& weight : weights) weight /= sum;
  const auto particles = weighted(weights);
  for (int trial = 0; trial < 100; ++trial) {
    const std::size_t count = 10 + random.below(500);
    std::map<int, int> drawn;
    for (const Particle& particle : resample_systematically(particles, count, random)) {
      EXPECT_DOUBLE_EQ(particle.weight, 1.0 / static_cast<double>(count));
      ++drawn[static_cast<int>(particle.x_m)];
    }
    int total = 0;
    for (std::size_t i = 0; i < weights.size(); ++i) {
      const double share = weights[i] * static_cast<double>(count);
      EXPECT_LE(std::abs(drawn[static_cast<int>(i)] - share), 1 + 1e-9);
      total += drawn[static_cast<int>(i)];
    }
    EXPECT_EQ(total, static_cast<int>(count));
  }
}

// Fox 2003, eq. 7, worked by hand for epsilon 0.05 and the 99 % quantile.
TEST(Resampling, TheKldCountIsThePublishedOne) {
  EXPECT_EQ(kld_count(0), 1U);
  EXPECT_EQ(kld_count(1), 1U);
  EXPECT_NEAR(static_cast<double>(kld_count(10)), 217, 1);
  EXPECT_NEAR(static_cast<double>(kld_count(20)), 362, 1);
  EXPECT_NEAR(static_cast<double>(kld_count(50)), 749, 1);
}

TEST(Resampling, CoarseSortingReclonesTheWorstAndKeepsTheBest) {
  constexpr int kCount = 1000;
  std::vector<double> weights;
  for (int i = 0; i < kCount; ++i) weights.push_back(2.0 * (i + 1) / kCount / (kCount + 1));
  auto particles = weighted(weights);
  RandomSource random(3);
  int clones = 0;
  int strangers = 0;
  double cloned_from = 0;
  const CoarseSorting sorting{[&](const Particle& from) {
                                ++clones;
                                cloned_from += from.x_m;
                                Particle clone = from;
                                clone.y_m = 1;
                                return clone;
                              },
                              [&] {
                                ++strangers;
                                Particle stranger;
                                stranger.y_m = 2;
                                return stranger;
                              }};
  sorting.apply(particles, random);
  EXPECT_EQ(clones, 400);
  EXPECT_EQ(strangers, 100);
  // The best 20 % by weight are numbers 800 to 999; ranks err, by 50 on average.
  EXPECT_NEAR(cloned_from / clones, 900, 30);
  double sum = 0;
  int best_kept = 0;
  for (int i = 0; i < kCount; ++i) {
    sum += particles[static_cast<std::size_t>(i)].weight;
    if (i >= 800 && particles[static_cast<std::size_t>(i)].y_m == 0) ++best_kept;
  }
  EXPECT_NEAR(sum, 1, 1e-12);
  EXPECT_EQ(best_kept, 200) << "the worst half and the best fifth are 6 sigmas of rank apart";
}

}  // namespace
}  // namespace cairn::localization
