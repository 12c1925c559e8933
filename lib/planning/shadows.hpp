// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>

namespace cairn::planning {

/// What things on the ground hide from an eye over it, seen from above.
class Shadows {
 public:
  explicit Shadows(const Eigen::Vector2d& eye_m);

  /// Something of this size stands there.
  void add(const Eigen::Vector2d& at_m, double size_m);

  /// Whether something stands between the eye and a point. True, too, up to a degree beside it.
  [[nodiscard]] bool hide(const Eigen::Vector2d& at_m) const;

 private:
  static constexpr int kBearings = 360;
  [[nodiscard]] static int bearing_of(double left_rad);

  Eigen::Vector2d eye_m_;
  std::array<float, kBearings> from_m_;  ///< by bearing: what is farther is hidden
};

}  // namespace cairn::planning
