// SPDX-License-Identifier: Apache-2.0
#include "evaluation/map_agreement.hpp"

#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace cairn::evaluation {
namespace {

using Points = std::vector<Eigen::Vector3d>;

TEST(MapAgreement, ByHand) {
  // 0 and 3 cm lie within 5 cm of a reference point, 20 cm does not; of the reference 1 cm is met,
  // 50 cm is not: P = 2/3, R = 1/2, F = 2 * (1/3) / (7/6) = 4/7.
  const Points points{{0, 0, 0}, {0.03, 0, 0}, {0.2, 0, 0}};
  const Points reference{{0.01, 0, 0}, {0.5, 0, 0}};
  const MapAgreement agreement = map_agreement(points, reference, 0.05);
  EXPECT_DOUBLE_EQ(*agreement.precision, 2.0 / 3);
  EXPECT_DOUBLE_EQ(*agreement.recall, 1.0 / 2);
  EXPECT_DOUBLE_EQ(*agreement.f_score, 4.0 / 7);
}

TEST(MapAgreement, IsThatOfBruteForce) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> metres(-0.5, 0.5);
  const auto cloud = [&](std::size_t count) {
    Points points(count);
    for (auto& point : points) point = {metres(random), metres(random), metres(random)};
    return points;
  };
  const Points points = cloud(400);
  const Points reference = cloud(300);
  const auto near = [](const Points& some, const Points& others) {
    double count = 0;
    for (const auto& point : some) {
      bool found = false;
      for (const auto& other : others) found = found || (point - other).norm() <= 0.07;
      count += found ? 1 : 0;
    }
    return count / static_cast<double>(some.size());
  };
  const MapAgreement agreement = map_agreement(points, reference, 0.07);
  EXPECT_DOUBLE_EQ(*agreement.precision, near(points, reference));
  EXPECT_DOUBLE_EQ(*agreement.recall, near(reference, points));
}

TEST(MapAgreement, OfNothingThereIsNone) {
  const Points one{{0, 0, 0}};
  EXPECT_FALSE(map_agreement({}, {}, 0.05).f_score);
  EXPECT_FALSE(map_agreement({}, one, 0.05).f_score);
  const Points far{{9, 0, 0}};
  EXPECT_EQ(map_agreement(far, one, 0.05).f_score, 0.0) << "there are points, and none agrees";
}

}  // namespace
}  // namespace cairn::evaluation
