// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "localization/pose_change.hpp"

namespace cairn::localization {

/// Rotations are weighed against translations as what they move at this distance [m].
inline constexpr double kLever_m = 2;

/// Turns a change of a pose (translation [m], rotation [rad]) into metres, entry by entry.
[[nodiscard]] Vector6d levers();

/// The covariance nearest to what sums and differences of estimates came to (Higham 1988, theorem
/// 2.1, rotations as metres at kLever_m): these may come out with negative variances. No direction
/// has less variance than `least_m2`.
[[nodiscard]] Matrix6d nearest_covariance(const Matrix6d& estimate, double least_m2);

}  // namespace cairn::localization
