// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "core/geometry.hpp"

namespace cairn::localization {

/// Of a small change of a pose T_map_body: translation along the map's axes [m], then rotation
/// about them [rad], the body's origin staying where it is.
using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// The pose after that change.
[[nodiscard]] Isometry changed_by(const Isometry& T_map_body, const Vector6d& change);

/// The change that makes `to` of `from`.
[[nodiscard]] Vector6d change_between(const Isometry& from, const Isometry& to);

}  // namespace cairn::localization
