// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>

#include "core/time.hpp"
#include "stereo/disparity_image.hpp"

namespace cairn::planning {

/// Whether each eye sees something, floor or thing, where it would see the nearest floor; by
/// bearing. What stands nearer than a matcher looks, and higher than a hand or two, leaves those
/// bearings without answers.
class NearSight {
 public:
  static constexpr int kBearings = 48;
  static constexpr double kBearing_rad = 0.03;

  /// Adds what an image answers where floor would lie view_from_m to 20 cm farther ahead of the
  /// body's origin.
  void look(const stereo::DisparityImage& image, double view_from_m);
  void forget() { *this = {}; }

  /// Whether both cameras would see near floor at a bearing from an eye (0 left, 1 right).
  [[nodiscard]] bool in_view(std::size_t eye, int bearing) const {
    return in_view_[eye][static_cast<std::size_t>(bearing)];
  }
  /// When an eye last had answers to most of what it would see there.
  [[nodiscard]] Utime answered(std::size_t eye, int bearing) const {
    return answered_[eye][static_cast<std::size_t>(bearing)];
  }
  /// In the body's frame, to the left of straight ahead.
  [[nodiscard]] static double bearing_rad(int bearing) {
    return (bearing + 0.5 - kBearings / 2) * kBearing_rad;
  }

 private:
  template <class T>
  using ByBearing = std::array<std::array<T, kBearings>, 2>;
  static constexpr Utime kNever = INT64_MIN / 2;

  ByBearing<bool> in_view_{};
  ByBearing<Utime> answered_ = [] {
    ByBearing<Utime> never;
    for (auto& eye : never) eye.fill(kNever);
    return never;
  }();
};

}  // namespace cairn::planning
