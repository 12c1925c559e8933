// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <random>

#include "messages/brick_packing.hpp"
#include "messages/map_messages.hpp"

namespace cairn::messages {
namespace {

using mapping::BrickClasses;
using mapping::MapDelta;

/// `wild` bricks hold noise; others one class, or a surface between two.
std::vector<BrickClasses> some_bricks(int count, bool wild, std::uint64_t seed) {
  std::mt19937_64 rng(seed);
  std::vector<BrickClasses> bricks;
  for (int i = 0; i < count; ++i) {
    BrickClasses brick;
    brick.brick = {i % 40 - 20, i / 40 % 40 - 20, i / 1600};
    brick.level = static_cast<std::uint8_t>(rng() % 4);
    const auto surface_at = static_cast<std::size_t>(rng() % 300);
    for (std::size_t byte = 0; byte < brick.classes.size(); ++byte) {
      brick.classes[byte] = byte < surface_at ? 0x55 : 0xaa;
      if (!wild) continue;
      brick.classes[byte] = 0;
      for (int pair = 0; pair < 4; ++pair) {
        brick.classes[byte] |= static_cast<std::uint8_t>(rng() % 3 << (2 * pair));
      }
    }
    bricks.push_back(brick);
  }
  return bricks;
}

std::vector<BrickClasses> in_order(std::vector<BrickClasses> bricks) {
  std::sort(bricks.begin(), bricks.end(), packs_before);
  return bricks;
}

std::vector<BrickClasses> received(const std::vector<map_delta_t>& messages) {
  std::vector<BrickClasses> bricks;
  for (const map_delta_t& message : messages) {
    EXPECT_LE(message.getEncodedSize(), kMaxMapMessage_bytes);
    EXPECT_TRUE(message.counts_agree());
    const auto part = to_delta(message);
    EXPECT_TRUE(part) << part.error().message;
    bricks.insert(bricks.end(), part->bricks.begin(), part->bricks.end());
  }
  return bricks;
}

TEST(MapMessages, BricksComeBackExactlyInOrder) {
  for (const int count : {0, 1, 2, 500, 5000}) {
    for (const bool wild : {false, true}) {
      auto bricks = some_bricks(count, wild, 3);
      std::shuffle(bricks.begin(), bricks.end(), std::mt19937_64(4));
      const auto messages = to_messages({7, 1234, 0.01, bricks}, DeltaKind::kChanges);
      ASSERT_TRUE(messages) << messages.error().message;
      EXPECT_EQ(received(*messages), in_order(bricks));
    }
  }
}

TEST(MapMessages, OnlyTheLastPartSaysThatAllIsThere) {
  const MapDelta delta{0xf00dULL << 50, 1234, 0.02, some_bricks(5000, true, 1)};
  const auto messages = to_messages(delta, DeltaKind::kChanges).value();
  ASSERT_GT(messages.size(), 1U);
  for (const map_delta_t& message : messages) {
    const bool last = &message == &messages.back();
    EXPECT_EQ(message.complete_through_utime, last ? 1234 : 0);
    const auto part = to_delta(message);
    EXPECT_EQ(part->complete_through, 1234);
    EXPECT_EQ(part->map_id, delta.map_id);
    EXPECT_EQ(part->resolution_m, 0.02);
  }
  const auto answers = to_messages(delta, DeltaKind::kAnswer).value();
  for (const map_delta_t& message : answers) {
    EXPECT_EQ(message.complete_through_utime, 0);
    EXPECT_EQ(message.header.utime, 1234);
  }
}

TEST(MapMessages, AChangeWithoutBricksStillSaysThroughWhichFrame) {
  const auto messages = to_messages({7, 55, 0.01, {}}, DeltaKind::kChanges).value();
  ASSERT_EQ(messages.size(), 1U);
  EXPECT_EQ(messages[0].complete_through_utime, 55);
  EXPECT_TRUE(to_delta(messages[0])->bricks.empty());
}

TEST(MapMessages, OfEqualBricksTheLastCounts) {
  auto bricks = some_bricks(2, false, 3);
  bricks[1] = bricks[0];
  bricks[1].classes.fill(0x55);
  const auto messages = to_messages({7, 55, 0.01, bricks}, DeltaKind::kChanges).value();
  EXPECT_EQ(received(messages), std::vector{bricks[1]});
}

TEST(MapMessages, AFreeRegionCostsNextToNothing) {
  std::vector<BrickClasses> bricks = some_bricks(10'000, false, 3);
  for (BrickClasses& brick : bricks) {
    brick.level = 0;
    brick.classes.fill(0x55);
  }
  const auto messages = to_messages({7, 55, 0.01, bricks}, DeltaKind::kChanges).value();
  ASSERT_EQ(messages.size(), 1U);
  std::printf("10,000 free bricks: %d bytes\n", messages[0].getEncodedSize());
  EXPECT_LT(messages[0].getEncodedSize(), 2000);
}

TEST(MapMessages, BricksThatNobodyWouldTakeAreNotSent) {
  const auto error = [](const BrickClasses& brick, double resolution_m = 0.01) {
    return to_messages({7, 55, resolution_m, {brick}}, DeltaKind::kChanges).error().message;
  };
  BrickClasses bad;
  bad.classes[5] = 0x30;
  EXPECT_EQ(error(bad), "MAP_DELTA: a voxel is of class 3, which means nothing");
  bad = {};
  bad.level = 4;
  EXPECT_EQ(error(bad), "MAP_DELTA: a brick is of level 4");
  bad = {};
  bad.brick.x = mapping::kBrickLimit;
  EXPECT_EQ(error(bad), "MAP_DELTA: a brick is out of range");
  EXPECT_EQ(error({}, 0), "MAP_DELTA resolution_m: is not a positive number");
}

TEST(MapMessages, BricksAtTheLimitsComeBack) {
  std::vector<BrickClasses> bricks(2);
  bricks[0].brick = {-mapping::kBrickLimit, mapping::kBrickLimit - 1, -mapping::kBrickLimit};
  bricks[1].brick = {mapping::kBrickLimit - 1, -mapping::kBrickLimit, mapping::kBrickLimit - 1};
  EXPECT_EQ(received(to_messages({7, 55, 0.01, bricks}, DeltaKind::kChanges).value()), bricks);
}

TEST(MapMessages, DeltasThatDoNotAddUpAreRefused) {
  const auto good =
      to_messages({7, 55, 0.01, some_bricks(50, true, 9)}, DeltaKind::kChanges).value()[0];
  const auto error = [](const map_delta_t& message) { return to_delta(message).error().message; };
  auto bad = good;
  bad.brick_count = 49;
  EXPECT_FALSE(to_delta(bad));
  bad.brick_count = 51;
  EXPECT_EQ(error(bad), "MAP_DELTA packed: not as many packed bricks as the message says");
  bad.brick_count = 2'000'000'000;
  EXPECT_EQ(error(bad), "MAP_DELTA packed: 2000000000 bricks: out of range");
  bad.brick_count = -1;
  EXPECT_EQ(error(bad), "MAP_DELTA packed: -1 bricks: out of range");
  bad = good;
  bad.packed[0] = 9;
  EXPECT_EQ(error(bad), "MAP_DELTA packed: packed in an unknown version");
  bad.packed.clear();
  EXPECT_EQ(error(bad), "MAP_DELTA packed: packed in an unknown version");
  bad = good;
  bad.resolution_m = -1;
  EXPECT_EQ(error(bad), "MAP_DELTA resolution_m: is not a positive number");
  auto twice = some_bricks(1, false, 1);
  twice.push_back(twice[0]);
  bad.resolution_m = 1;
  bad.brick_count = 2;
  bad.packed = pack(twice);
  EXPECT_EQ(error(bad), "MAP_DELTA packed: packed bricks are not in order");
}

TEST(MapMessages, ADigestComesBackPageByPage) {
  MapDigest digest{42, 0.01, 77, {}};
  for (int i = 0; i < 9000; ++i) {
    digest.tiles.push_back({{i / 100 - 30, i % 100, -i}, ~static_cast<std::uint64_t>(i)});
  }
  const auto pages = to_messages(digest, 80);
  ASSERT_EQ(pages.size(), 3U);
  std::vector<TileHash> tiles;
  for (const map_digest_t& page : pages) {
    EXPECT_LE(page.getEncodedSize(), kMaxMapMessage_bytes);
    EXPECT_EQ(page.page_count, 3);
    EXPECT_EQ(page.header.utime, 80);
    const auto part = to_digest(page);
    ASSERT_TRUE(part) << part.error().message;
    EXPECT_EQ(part->map_id, 42U);
    EXPECT_EQ(part->complete_through, 77);
    tiles.insert(tiles.end(), part->tiles.begin(), part->tiles.end());
  }
  EXPECT_EQ(tiles, digest.tiles);
  EXPECT_EQ(to_messages(MapDigest{42, 0.01, 77, {}}, 80).size(), 1U);
}

TEST(MapMessages, DigestsThatDoNotAddUpAreRefused) {
  const auto good = to_messages(MapDigest{42, 0.01, 77, {{{1, 2, 3}, 4}, {{1, 2, 4}, 4}}}, 80)[0];
  auto bad = good;
  bad.tile_count = 3;
  EXPECT_EQ(to_digest(bad).error().message, "MAP_DIGEST tile_count: not that of its lists");
  bad = good;
  bad.tile_z[1] = 3;
  EXPECT_EQ(to_digest(bad).error().message,
            "MAP_DIGEST tile_x, tile_y, tile_z: tile 1 is not in order");
  bad = good;
  bad.tile_x[0] = mapping::kTileLimit;
  EXPECT_EQ(to_digest(bad).error().message,
            "MAP_DIGEST tile_x, tile_y, tile_z: tile 0 is out of range");
  bad = good;
  bad.page = 1;
  EXPECT_EQ(to_digest(bad).error().message, "MAP_DIGEST page: 1 of 1");
  bad = good;
  bad.resolution_m = NAN;
  EXPECT_EQ(to_digest(bad).error().message, "MAP_DIGEST resolution_m: is not a positive number");
}

TEST(MapMessages, ARequestComesBackAndNoneMeansAll) {
  const MapRequest request{42, {{3, 2, 1}, {-1, 0, 5}}};
  const auto back = to_request(to_messages(request, 5)[0]);
  ASSERT_TRUE(back);
  EXPECT_EQ(back->tiles, request.tiles);
  EXPECT_EQ(back->map_id, 42U);
  EXPECT_TRUE(to_request(to_messages(MapRequest{42, {}}, 5)[0])->tiles.empty());
  auto bad = to_messages(request, 5)[0];
  bad.tile_y[0] = -mapping::kTileLimit - 1;
  EXPECT_FALSE(to_request(bad));
}

}  // namespace
}  // namespace cairn::messages
