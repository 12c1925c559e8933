// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cairn/isometry_t.hpp>
#include <cairn/twist_t.hpp>
#include <string_view>

#include "core/geometry.hpp"
#include "core/result.hpp"

namespace cairn::messages {

/// Positions farther from the origin than this are refused [m].
inline constexpr double kMaxPosition_m = 1e6;

/// The pose as it goes over the bus: the unit quaternion with w >= 0 (where w = 0, the first of x,
/// y, z that is not 0 is positive), its three smaller components rounded to multiples of 2^-46, so
/// that to_message and to_isometry undo each other bit for bit on everything that has been through
/// a message once. Rounding turns by less than 1e-13 rad.
[[nodiscard]] isometry_t to_message(const Isometry& T);

/// Refuses, naming `field`: numbers that are not finite, a position beyond kMaxPosition_m on an
/// axis, a quaternion whose norm is off 1 by more than 1e-3.
[[nodiscard]] Result<Isometry> to_isometry(const isometry_t& message, std::string_view field);

/// What receivers of `T` will have: to_isometry(to_message(T)). Whoever sends a pose and goes on
/// computing with it uses this one, so that sender, receivers and a replay agree to the bit.
[[nodiscard]] Isometry as_sent(const Isometry& T);

/// Velocity of a body in its own axes.
struct Twist {
  Eigen::Vector3d linear_mps = Eigen::Vector3d::Zero();
  Eigen::Vector3d angular_radps = Eigen::Vector3d::Zero();
};

[[nodiscard]] twist_t to_message(const Twist& twist);

/// Refuses, naming `field`, numbers that are not finite.
[[nodiscard]] Result<Twist> to_twist(const twist_t& message, std::string_view field);

/// Covariance of x y z [m] and the rotation about x y z [rad].
using Covariance6 = Eigen::Matrix<double, 6, 6>;

void set_covariance(double (&row_by_row)[36], const Covariance6& covariance);

/// Refuses, naming `field`, what no random vector can have: numbers that are not finite, a negative
/// variance, entries that are not symmetric, a correlation beyond 1 (1e-6 of slack for rounding).
[[nodiscard]] Result<Covariance6> to_covariance(const double (&row_by_row)[36],
                                                std::string_view field);

}  // namespace cairn::messages
