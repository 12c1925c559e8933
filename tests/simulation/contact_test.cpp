// SPDX-License-Identifier: Apache-2.0
#include "simulation/contact.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

namespace cairn::simulation {
namespace {

struct Solid {
  Isometry T_world_box = Isometry::Identity();
  Eigen::Vector3d half_m = Eigen::Vector3d::Ones();

  [[nodiscard]] Eigen::Vector3d nearest_to(const Eigen::Vector3d& point) const {
    const Eigen::Vector3d inside = T_world_box.inverse() * point;
    return T_world_box * inside.cwiseMax(-half_m).cwiseMin(half_m).eval();
  }
  [[nodiscard]] Solid moved(const Eigen::Vector2d& by_m) const {
    Solid other = *this;
    other.T_world_box.translation().head<2>() += by_m;
    return other;
  }
};

Contact contact(const Solid& a, const Solid& b) {
  return box_contact(a.T_world_box, a.half_m, b.T_world_box, b.half_m);
}

/// Distance of two convex solids by projecting to and fro (Cheney and Goldstein 1959), which knows
/// nothing of separating axes. Slow to settle where they all but touch: those come out too far
/// apart.
double distance_m(const Solid& a, const Solid& b) {
  Eigen::Vector3d on_a = a.T_world_box.translation();
  Eigen::Vector3d on_b = on_a;
  for (int i = 0; i < 4000; ++i) {
    on_b = b.nearest_to(on_a);
    const Eigen::Vector3d next = a.nearest_to(on_b);
    if ((next - on_a).norm() < 1e-12) break;
    on_a = next;
  }
  return (on_a - on_b).norm();
}

Solid random_solid(std::mt19937& random, bool upright) {
  std::uniform_real_distribution<double> unit(-1, 1);
  Solid solid;
  solid.half_m = Eigen::Vector3d(unit(random), unit(random), unit(random)).cwiseAbs() * 0.4 +
                 Eigen::Vector3d::Constant(0.02);
  const double tilt = upright ? 0 : 1;
  solid.T_world_box.linear() =
      rotation_from_rpy(tilt * unit(random), tilt * unit(random), 3 * unit(random));
  solid.T_world_box.translation() = 0.6 * Eigen::Vector3d(unit(random), unit(random), unit(random));
  return solid;
}

class BoxContact : public testing::TestWithParam<bool> {};

TEST_P(BoxContact, TellsOverlapFromGapAsProjectionsDo) {
  std::mt19937 random(7);
  int overlaps = 0;
  constexpr int kPairs = 2000;
  for (int i = 0; i < kPairs; ++i) {
    const Solid a = random_solid(random, GetParam());
    const Solid b = random_solid(random, GetParam());
    const double gap_m = contact(a, b).gap_m;
    const double apart_m = distance_m(a, b);
    if (gap_m > 1e-3) {
      EXPECT_GE(apart_m, gap_m - 1e-9);
    } else if (gap_m < -1e-3) {
      EXPECT_LT(apart_m, 1e-3);
      ++overlaps;
    }
  }
  EXPECT_GT(overlaps, kPairs / 10);
  EXPECT_LT(overlaps, kPairs * 9 / 10);
}

TEST_P(BoxContact, PartsByTheShortestLevelPush) {
  std::mt19937 random(8);
  int checked = 0;
  while (checked < 200) {
    const Solid a = random_solid(random, GetParam());
    const Solid b = random_solid(random, GetParam());
    const Contact found = contact(a, b);
    if (found.gap_m > -5e-3) continue;
    ++checked;
    EXPECT_NEAR(found.away.norm(), 1, 1e-12);
    const double depth_m = -found.gap_m;
    EXPECT_GT(contact(a.moved((depth_m + 1e-6) * found.away), b).gap_m, 0);
    for (int k = 0; k < 72; ++k) {
      const double angle = k * std::numbers::pi / 36;
      const Eigen::Vector2d push =
          0.9 * depth_m * Eigen::Vector2d(std::cos(angle), std::sin(angle));
      EXPECT_LT(distance_m(a.moved(push), b), 1e-3) << k;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Boxes, BoxContact, testing::Bool(), [](const auto& boxes) {
  return boxes.param ? std::string("Upright") : std::string("Tilted");
});

TEST(BoxContact, OneAboveTheOtherIsNone) {
  Solid floor;
  floor.half_m = {3, 3, 0.1};
  Solid body;
  body.half_m = {0.18, 0.15, 0.19};
  body.T_world_box.translation().z() = 0.1 + 0.19 + 0.001;
  EXPECT_NEAR(contact(body, floor).gap_m, 0.001, 1e-12);
}

}  // namespace
}  // namespace cairn::simulation
