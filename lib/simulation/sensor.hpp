// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <opencv2/core.hpp>

#include "core/config.hpp"

namespace cairn::simulation {

/// How the two sensors differ from perfect ones and from each other.
struct SensorConfig {
  double read_noise_grey = 1.5;
  double shot_noise_grey = 0.02;
  double right_gain = 1.06;
  double right_offset_grey = 2;
  double exposure_drift = 0.06;
  int exposure_period_frames = 450;

  void visit(ConfigVisitor& v) {
    v.number("read_noise_grey", read_noise_grey, {0, 50}, "grey",
             "standard deviation of the noise of a black pixel");
    v.number("shot_noise_grey", shot_noise_grey, {0, 10}, "grey",
             "variance that the noise gains per grey level");
    v.number("right_gain", right_gain, {0.2, 5}, "",
             "exposure of the right camera over the left's");
    v.number("right_offset_grey", right_offset_grey, {-100, 100}, "grey",
             "black level of the right camera less the left's");
    v.number("exposure_drift", exposure_drift, {0, 0.5}, "",
             "how far both cameras' exposure wanders from that of frame 0, as a share of it");
    v.integer("exposure_period_frames", exposure_period_frames, 2, 1'000'000, "frames",
              "how long its slower wave is");
  }
};

/// Turns light into grey values as a pair of cameras does.
class Sensor {
 public:
  Sensor(const SensorConfig& config, std::uint64_t seed);

  /// Exposure of both cameras in a frame over that of frame 0.
  [[nodiscard]] double exposure(std::int64_t frame) const;

  /// Grey values with noise out of light (grey values without noise, at exposure 1). Every frame
  /// and either camera (0 left, 1 right) has a noise of its own.
  void take(const cv::Mat_<float>& light, std::int64_t frame, int camera,
            cv::Mat_<std::uint8_t>& image) const;

 private:
  static constexpr std::size_t kNoiseBits = 12;
  SensorConfig config_;
  std::uint64_t seed_;
  std::array<float, 256> deviation_{};                        ///< of each grey value
  std::array<float, std::size_t{1} << kNoiseBits> normal_{};  ///< numbers of deviation 1
};

}  // namespace cairn::simulation
