// SPDX-License-Identifier: Apache-2.0
#include "mapping/evidence_plane.hpp"

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <algorithm>
#include <cstdint>
#include <random>

#include "mapping/made_maps.hpp"

namespace cairn::mapping {
namespace {

EvidencePlane random_plane(std::mt19937& random) {
  EvidencePlane plane;
  for (std::uint8_t& value : plane.of) value = static_cast<std::uint8_t>(random());
  return plane;
}

// On every kind of processor that this one can be, the plain one among them.
TEST(EvidencePlane, AddsAndComparesAsPlainArithmeticDoes) {
  std::mt19937 random{5};
  int targets = 0;
  for (std::int64_t left = hwy::SupportedTargets(); left != 0; left &= left - 1, ++targets) {
    hwy::SetSupportedTargetsForTest(left & ~(left - 1));
    for (const int evidence : {0, 1, 2, 77, 255}) {
      const EvidencePlane before = random_plane(random);
      const VoxelMask voxels = testing::random_mask(random, 0.4);
      EvidencePlane after = before;
      after.add(voxels, static_cast<std::uint8_t>(evidence));
      const VoxelMask at_least = before.at_least(evidence);
      for (int i = 0; i < kBrickVoxels; ++i) {
        const int was = before.of[static_cast<std::size_t>(i)];
        const int expected = voxels.test(i) ? std::min(255, was + evidence) : was;
        ASSERT_EQ(after.of[static_cast<std::size_t>(i)], expected);
        ASSERT_EQ(at_least.test(i), was >= evidence);
      }
    }
    hwy::SetSupportedTargetsForTest(0);
  }
  EXPECT_GT(targets, 1) << "this processor has no wide registers to compare with";
  EXPECT_FALSE(random_plane(random).at_least(256).any());
}

}  // namespace
}  // namespace cairn::mapping
