// SPDX-License-Identifier: Apache-2.0
#include "localization/resampling.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace cairn::localization {

double effective_count(const std::vector<Particle>& particles) {
  double squares = 0;
  for (const Particle& particle : particles) squares += particle.weight * particle.weight;
  return squares > 0 ? 1 / squares : 0;
}

std::vector<Particle> resample_systematically(const std::vector<Particle>& particles,
                                              std::size_t count, RandomSource& random) {
  std::vector<Particle> drawn;
  drawn.reserve(count);
  const double each = 1.0 / static_cast<double>(count);
  double next = random.uniform() * each;
  double passed = 0;
  for (const Particle& particle : particles) {
    passed += particle.weight;
    while (next < passed && drawn.size() < count) {
      drawn.push_back(particle);
      next += each;
    }
  }
  // What rounding kept from being drawn.
  while (drawn.size() < count) drawn.push_back(particles.back());
  for (Particle& particle : drawn) particle.weight = each;
  return drawn;
}

std::size_t kld_count(std::size_t bins) {
  if (bins < 2) return 1;
  constexpr double kError = 0.05;
  constexpr double kQuantile = 2.326;  // of the normal distribution, at 0.99
  const double k = static_cast<double>(bins - 1);
  const double a = 2 / (9 * k);
  const double b = 1 - a + std::sqrt(a) * kQuantile;
  return static_cast<std::size_t>(std::ceil(k / (2 * kError) * b * b * b));
}

void CoarseSorting::apply(std::vector<Particle>& particles, RandomSource& random) const {
  const std::size_t count = particles.size();
  if (count < 5) return;
  std::vector<std::size_t> by_weight(count);
  std::iota(by_weight.begin(), by_weight.end(), std::size_t{0});
  std::stable_sort(by_weight.begin(), by_weight.end(), [&](std::size_t a, std::size_t b) {
    return particles[a].weight > particles[b].weight;
  });
  std::vector<std::pair<double, std::size_t>> ranked;
  ranked.reserve(count);
  for (std::size_t rank = 0; rank < count; ++rank) {
    const double error = kRankError * static_cast<double>(count) * random.normal();
    ranked.emplace_back(static_cast<double>(rank) + error, by_weight[rank]);
  }
  std::sort(ranked.begin(), ranked.end());
  const auto part = [count](double share) {
    return static_cast<std::size_t>(share * static_cast<double>(count));
  };
  const std::size_t best = part(kBest);
  const std::size_t recloned_from = count - part(kRecloned);
  const std::size_t random_from = recloned_from - part(kRandom);
  const double even = 1.0 / static_cast<double>(count);
  for (std::size_t rank = random_from; rank < count; ++rank) {
    Particle& place = particles[ranked[rank].second];
    place = rank < recloned_from ? anywhere() : near(particles[ranked[random.below(best)].second]);
    place.weight = even;
  }
  const double sum = std::accumulate(
      particles.begin(), particles.end(), 0.0,
      [](double so_far, const Particle& particle) { return so_far + particle.weight; });
  for (Particle& particle : particles) particle.weight /= sum;
}

}  // namespace cairn::localization
