// SPDX-License-Identifier: Apache-2.0
#include "messages/geometry_messages.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

namespace cairn::messages {
namespace {

constexpr double kSteps = 0x1p46;
constexpr double kTie = 1e-9;
constexpr double kNormSlack = 1e-3;

/// x, y, z, w
using Quaternion = std::array<double, 4>;

/// The component that follows from the other three: the largest, of near equals w first.
std::size_t derived_component(const Quaternion& q) {
  const double largest = std::max({std::abs(q[0]), std::abs(q[1]), std::abs(q[2]), std::abs(q[3])});
  for (const std::size_t i : {3U, 0U, 1U}) {
    if (std::abs(q[i]) >= largest - kTie) return i;
  }
  return 2;
}

Quaternion rounded(Quaternion q) {
  const std::size_t derived = derived_component(q);
  double rest = 1;
  for (std::size_t i = 0; i < 4; ++i) {
    if (i == derived) continue;
    q[i] = std::round(q[i] * kSteps) / kSteps;
    rest -= q[i] * q[i];
  }
  q[derived] = std::copysign(std::sqrt(rest), q[derived]);
  return q;
}

Quaternion with_positive_w(Quaternion q) {
  double sign = 1;
  for (const std::size_t i : {3U, 0U, 1U, 2U}) {
    if (q[i] == 0) continue;
    sign = q[i] < 0 ? -1 : 1;
    break;
  }
  for (double& component : q) component = component * sign + 0.0;  // no negative zeros
  return q;
}

bool all_finite(const double* begin, std::size_t count) {
  return std::all_of(begin, begin + count, [](double x) { return std::isfinite(x); });
}

}  // namespace

isometry_t to_message(const Isometry& T) {
  const Eigen::Quaterniond q = Eigen::Quaterniond(T.linear()).normalized();
  const Quaternion canonical = with_positive_w(rounded({q.x(), q.y(), q.z(), q.w()}));
  isometry_t message{};
  for (int i = 0; i < 3; ++i) message.position_m[i] = T.translation()[i];
  std::copy(canonical.begin(), canonical.end(), message.orientation_xyzw);
  return message;
}

Result<Isometry> to_isometry(const isometry_t& message, std::string_view field) {
  const std::string name(field);
  const double* p = message.position_m;
  if (!all_finite(p, 3)) return fail(name + ".position_m: not finite");
  if (std::any_of(p, p + 3, [](double x) { return std::abs(x) > kMaxPosition_m; })) {
    return fail(name + ".position_m: farther than 1e6 m");
  }
  const double* q = message.orientation_xyzw;
  if (!all_finite(q, 4)) return fail(name + ".orientation_xyzw: not finite");
  const Eigen::Quaterniond quaternion(q[3], q[0], q[1], q[2]);
  const double norm = quaternion.norm();
  if (!(std::abs(norm - 1) <= kNormSlack)) {
    return fail(name + ".orientation_xyzw: norm " + std::to_string(norm) + ", not a rotation");
  }
  Isometry T = Isometry::Identity();
  T.linear() = quaternion.normalized().toRotationMatrix();
  T.translation() = Eigen::Vector3d(p[0], p[1], p[2]);
  return T;
}

Isometry as_sent(const Isometry& T) {
  const isometry_t message = to_message(T);
  return to_isometry(message, "pose").value_or(T);
}

twist_t to_message(const Twist& twist) {
  twist_t message{};
  for (int i = 0; i < 3; ++i) {
    message.linear_mps[i] = twist.linear_mps[i];
    message.angular_radps[i] = twist.angular_radps[i];
  }
  return message;
}

Result<Twist> to_twist(const twist_t& message, std::string_view field) {
  if (!all_finite(message.linear_mps, 3) || !all_finite(message.angular_radps, 3)) {
    return fail(std::string(field) + ": not finite");
  }
  return Twist{Eigen::Vector3d(message.linear_mps), Eigen::Vector3d(message.angular_radps)};
}

void set_covariance(double (&row_by_row)[36], const Covariance6& covariance) {
  for (int row = 0; row < 6; ++row) {
    for (int column = 0; column < 6; ++column)
      row_by_row[6 * row + column] = covariance(row, column);
  }
}

Result<Covariance6> to_covariance(const double (&row_by_row)[36], std::string_view field) {
  const std::string name(field);
  if (!all_finite(row_by_row, 36)) return fail(name + ": not finite");
  Covariance6 covariance;
  for (int i = 0; i < 36; ++i) covariance(i / 6, i % 6) = row_by_row[i];
  for (int i = 0; i < 6; ++i) {
    if (covariance(i, i) < 0) {
      return fail(name + ": negative variance in row " + std::to_string(i));
    }
  }
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j < i; ++j) {
      const double scale = std::sqrt(covariance(i, i)) * std::sqrt(covariance(j, j));
      const std::string where = std::to_string(i) + ", column " + std::to_string(j);
      if (std::abs(covariance(i, j) - covariance(j, i)) > 1e-6 * scale) {
        return fail(name + ": not symmetric in row " + where);
      }
      if (std::abs(covariance(i, j)) > (1 + 1e-6) * scale) {
        return fail(name + ": correlation beyond 1 in row " + where);
      }
    }
  }
  return covariance;
}

}  // namespace cairn::messages
