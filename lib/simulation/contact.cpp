// SPDX-License-Identifier: Apache-2.0
#include "simulation/contact.hpp"

#include <cmath>
#include <limits>

namespace cairn::simulation {
namespace {

/// An axis this near to upright says nothing about level pushes.
constexpr double kUpright = 0.02;
/// Cross products of edges that are as good as parallel have no direction.
constexpr double kParallel = 1e-9;

struct Search {
  Eigen::Vector3d between_m;  ///< from b's middle to a's
  Eigen::Matrix3d edges_a;    ///< half edges as columns
  Eigen::Matrix3d edges_b;
  double widest_gap_m = -std::numeric_limits<double>::infinity();
  double shallowest_m = std::numeric_limits<double>::infinity();
  Eigen::Vector2d away = Eigen::Vector2d::UnitX();
  Eigen::Vector2d away_apart = Eigen::Vector2d::UnitX();

  void look_along(const Eigen::Vector3d& direction) {
    const double length = direction.norm();
    if (length < kParallel) return;
    const Eigen::Vector3d axis = direction / length;
    const double offset = axis.dot(between_m);
    const double reach = (edges_a.transpose() * axis).cwiseAbs().sum() +
                         (edges_b.transpose() * axis).cwiseAbs().sum();
    const double gap_m = std::abs(offset) - reach;
    const double level = axis.head<2>().norm();
    const Eigen::Vector2d push =
        level > kUpright ? Eigen::Vector2d((offset < 0 ? -1 : 1) / level * axis.head<2>())
                         : Eigen::Vector2d::UnitX();
    if (gap_m > widest_gap_m) {
      widest_gap_m = gap_m;
      away_apart = push;
    }
    if (level > kUpright && -gap_m / level < shallowest_m) {
      shallowest_m = -gap_m / level;
      away = push;
    }
  }
};

}  // namespace

Contact box_contact(const Isometry& T_world_a, const Eigen::Vector3d& half_a_m,
                    const Isometry& T_world_b, const Eigen::Vector3d& half_b_m) {
  Search search;
  search.between_m = T_world_a.translation() - T_world_b.translation();
  search.edges_a = T_world_a.linear() * half_a_m.asDiagonal();
  search.edges_b = T_world_b.linear() * half_b_m.asDiagonal();
  for (int i = 0; i < 3; ++i) {
    search.look_along(T_world_a.linear().col(i));
    search.look_along(T_world_b.linear().col(i));
    for (int j = 0; j < 3; ++j) {
      search.look_along(T_world_a.linear().col(i).cross(T_world_b.linear().col(j)));
    }
  }
  if (search.widest_gap_m > 0) return {search.widest_gap_m, search.away_apart};
  return {-search.shallowest_m, search.away};
}

}  // namespace cairn::simulation
