// SPDX-License-Identifier: Apache-2.0
#include "simulation/sensor.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "simulation/random_hash.hpp"

namespace cairn::simulation {
namespace {

/// The number that a normal variable stays below with this probability (Newton's method, from a
/// smaller one's).
double normal_quantile(double probability, double start) {
  double x = start;
  for (int i = 0; i < 20; ++i) {
    const double cumulative = 0.5 * std::erfc(-x / std::numbers::sqrt2);
    const double density = std::exp(-0.5 * x * x) / std::sqrt(2 * std::numbers::pi);
    x += std::clamp((probability - cumulative) / density, -0.5, 0.5);
  }
  return x;
}

}  // namespace

Sensor::Sensor(const SensorConfig& config, std::uint64_t seed) : config_{config}, seed_{seed} {
  for (std::size_t grey = 0; grey < deviation_.size(); ++grey) {
    deviation_[grey] =
        static_cast<float>(std::sqrt(config.read_noise_grey * config.read_noise_grey +
                                     config.shot_noise_grey * static_cast<double>(grey)));
  }
  double quantile = -3.7;
  double sum_of_squares = 0;
  const auto count = static_cast<double>(normal_.size());
  for (std::size_t i = 0; i < normal_.size(); ++i) {
    quantile = normal_quantile((static_cast<double>(i) + 0.5) / count, quantile);
    normal_[i] = static_cast<float>(quantile);
    sum_of_squares += quantile * quantile;
  }
  const auto scale = static_cast<float>(std::sqrt(count / sum_of_squares));
  for (float& number : normal_) number *= scale;
}

double Sensor::exposure(std::int64_t frame) const {
  constexpr double kTurn = 2 * std::numbers::pi;
  constexpr double kFasterPeriod = 0.38;
  const double turns = static_cast<double>(frame) / config_.exposure_period_frames;
  const auto wave = [](double angle, double phase) {
    return std::sin(angle + phase) - std::sin(phase);
  };
  const double slow = wave(kTurn * turns, kTurn * unit_random(hash64(seed_, 101)));
  const double fast = wave(kTurn * turns / kFasterPeriod, kTurn * unit_random(hash64(seed_, 102)));
  return 1 + config_.exposure_drift * (0.35 * slow + 0.15 * fast);
}

void Sensor::take(const cv::Mat_<float>& light, std::int64_t frame, int camera,
                  cv::Mat_<std::uint8_t>& image) const {
  constexpr int kPerHash = 4;
  const bool right = camera == 1;
  const auto gain = static_cast<float>(exposure(frame) * (right ? config_.right_gain : 1.0));
  const auto offset = static_cast<float>(right ? config_.right_offset_grey : 0.0);
  const std::uint64_t seed =
      hash64(hash64(seed_, static_cast<std::uint64_t>(frame)), static_cast<std::uint64_t>(camera));
  image.create(light.size());
  for (int row = 0; row < light.rows; ++row) {
    const std::uint64_t row_seed = hash64(seed, static_cast<std::uint64_t>(row));
    const float* const in = light[row];
    std::uint8_t* const out = image[row];
    for (int begin = 0; begin < light.cols; begin += kPerHash) {
      std::uint64_t random = hash64(row_seed + static_cast<std::uint64_t>(begin));
      for (int col = begin; col < std::min(begin + kPerHash, light.cols); ++col) {
        const float grey = std::clamp(gain * in[col] + offset, 0.0F, 255.0F);
        const float noise = normal_[random & (normal_.size() - 1)];
        random >>= 16;
        const float value = grey + deviation_[static_cast<std::size_t>(grey)] * noise;
        out[col] = static_cast<std::uint8_t>(std::clamp(value + 0.5F, 0.0F, 255.0F));
      }
    }
  }
}

}  // namespace cairn::simulation
