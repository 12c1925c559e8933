// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace cairn::testing {

/// A value in [0, 1) for each whole-numbered place (the finaliser of MurmurHash3, Appleby 2011).
[[nodiscard]] inline double lattice_value(std::int64_t x, std::int64_t y, std::uint64_t seed) {
  std::uint64_t h = seed * 0x9e3779b97f4a7c15ULL ^
                    static_cast<std::uint64_t>(x) * 0xc2b2ae3d27d4eb4fULL ^
                    static_cast<std::uint64_t>(y) * 0x165667b19e3779f9ULL;
  h = (h ^ (h >> 33)) * 0xff51afd7ed558ccdULL;
  h = (h ^ (h >> 33)) * 0xc4ceb9fe1a85ec53ULL;
  return static_cast<double>((h ^ (h >> 33)) >> 11) / 9007199254740992.0;
}

/// Smooth noise of mean 0.5 with features of one unit (value noise, Perlin's smooth step between
/// lattice values).
[[nodiscard]] inline double smooth_noise(double x, double y, std::uint64_t seed) {
  const double x0 = std::floor(x);
  const double y0 = std::floor(y);
  const auto fade = [](double t) { return t * t * t * (t * (t * 6 - 15) + 10); };
  const double tx = fade(x - x0);
  const double ty = fade(y - y0);
  const auto i = static_cast<std::int64_t>(x0);
  const auto j = static_cast<std::int64_t>(y0);
  const double top = std::lerp(lattice_value(i, j, seed), lattice_value(i + 1, j, seed), tx);
  const double bottom =
      std::lerp(lattice_value(i, j + 1, seed), lattice_value(i + 1, j + 1, seed), tx);
  return std::lerp(top, bottom, ty);
}

/// Grey value 20 to 235 of a surface at (x, y), with features from `feature` to eight times that.
[[nodiscard]] inline double surface_grey(double x, double y, double feature, std::uint64_t seed) {
  double sum = 0;
  for (int octave = 0; octave < 4; ++octave) {
    const double size = feature * (1 << octave);
    sum += smooth_noise(x / size, y / size, seed + static_cast<std::uint64_t>(octave)) / 4;
  }
  return 20 + 215 * std::clamp(0.5 + 2 * (sum - 0.5), 0.0, 1.0);
}

}  // namespace cairn::testing
