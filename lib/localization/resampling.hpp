// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "localization/particle.hpp"
#include "localization/random_source.hpp"

namespace cairn::localization {

/// 1 / sum of squared weights: how many particles share the weight (Kong, Liu and Wong 1994).
[[nodiscard]] double effective_count(const std::vector<Particle>& particles);

/// `count` particles drawn by weight with one random number (systematic resampling, Carpenter,
/// Clifford and Fearnhead 1999): each appears floor or ceil of count * weight times. Weights become
/// even. The weights must sum to 1.
[[nodiscard]] std::vector<Particle> resample_systematically(const std::vector<Particle>& particles,
                                                            std::size_t count,
                                                            RandomSource& random);

/// How many particles tell `bins` occupied bins from the truth with an error of at most 0.05 in
/// Kullback-Leibler distance, 99 times in 100 (Fox 2003, eq. 7).
[[nodiscard]] std::size_t kld_count(std::size_t bins);

/// The coarse random sorting of Ferrese (2012): ranked by weight, with a random error in rank; the
/// worst 40 % are cloned anew from the best 20 %, through `near`, which spreads a clone; the next
/// worst 10 % are replaced by `anywhere`; the rest stay. Clones and strangers get even weight.
struct CoarseSorting {
  static constexpr double kRecloned = 0.4;
  static constexpr double kBest = 0.2;
  static constexpr double kRandom = 0.1;
  static constexpr double kRankError = 0.05;  ///< of all, one sigma

  std::function<Particle(const Particle&)> near;
  std::function<Particle()> anywhere;

  void apply(std::vector<Particle>& particles, RandomSource& random) const;
};

}  // namespace cairn::localization
