// SPDX-License-Identifier: Apache-2.0
#include "mapping/map_file.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <limits>
#include <random>
#include <vector>

#include "mapping/corruption.hpp"
#include "mapping/made_maps.hpp"
#include "mapping/resealed.hpp"
#include "temporary_folder.hpp"

namespace cairn::mapping {
namespace {

using testing::Bytes;

const MapInfo kInfo{0x1234567890abcdefULL, 1'700'000'000'000'000};

void expect_refused(const Bytes& bytes, const std::string& why) {
  const auto loaded = decode_map(bytes, "some/map.cairn", {});
  ASSERT_FALSE(loaded) << why;
  EXPECT_EQ(loaded.error().message.rfind("some/map.cairn: ", 0), 0u) << loaded.error().message;
  EXPECT_NE(loaded.error().message.find(why), std::string::npos) << loaded.error().message;
}

TEST(MapFile, RoundTripKeepsEverythingAndTheBytes) {
  const cairn::testing::TemporaryFolder folder;
  const VoxelMap map = testing::random_map(31, 500);
  const auto path = folder.path() / "map.cairn";
  ASSERT_TRUE(save_map(path, map, kInfo));
  const auto loaded = load_map(path, {});
  ASSERT_TRUE(loaded) << loaded.error().message;
  EXPECT_EQ(loaded->info, kInfo);
  EXPECT_EQ(loaded->map.resolution_m(), map.resolution_m());
  EXPECT_EQ(loaded->map.brick_count(), map.brick_count());
  EXPECT_EQ(loaded->map.known_voxels(), map.known_voxels());
  EXPECT_EQ(loaded->map.occupied_voxels(), map.occupied_voxels());
  EXPECT_TRUE(loaded->map.dirty_bricks().empty());
  map.grid().for_each([&](BrickIndex index, const EvidenceBrick& brick) {
    const EvidenceBrick* copy = loaded->map.grid().find(index);
    ASSERT_NE(copy, nullptr);
    EXPECT_EQ(copy->occupied_evidence, brick.occupied_evidence);
    EXPECT_EQ(copy->empty_evidence(), brick.empty_evidence());
  });
  const Bytes bytes = encode_map(map, kInfo);
  EXPECT_EQ(encode_map(loaded->map, loaded->info), bytes);
  EXPECT_EQ(loaded->content_id, content_id_of(bytes));
}

TEST(MapFile, AnEmptyMapIsAMap) {
  const auto loaded = decode_map(encode_map(VoxelMap{0.01}, kInfo), "map", {});
  ASSERT_TRUE(loaded) << loaded.error().message;
  EXPECT_EQ(loaded->map.brick_count(), 0u);
  EXPECT_EQ(loaded->map.resolution_m(), 0.01);
}

TEST(MapFile, TheOrderInWhichBricksCameDoesNotShow) {
  const VoxelMap map = testing::random_map(32, 300);
  std::vector<BrickIndex> bricks;
  map.grid().for_each([&](BrickIndex index, const EvidenceBrick&) { bricks.push_back(index); });
  std::shuffle(bricks.begin(), bricks.end(), std::mt19937{33});
  VoxelMap other{map.resolution_m()};
  for (const BrickIndex index : bricks) {
    const EvidenceBrick* brick = map.grid().find(index);
    other.set_evidence(index, brick->occupied_evidence.of, brick->empty_evidence().of);
  }
  EXPECT_EQ(encode_map(other, kInfo), encode_map(map, kInfo));
}

TEST(MapFile, DifferentContentHasADifferentId) {
  VoxelMap map = testing::random_map(34, 50);
  const std::uint64_t before = content_id_of(encode_map(map, kInfo));
  EXPECT_NE(before, content_id_of(encode_map(map, {kInfo.map_id, kInfo.last_utime + 1})));
  VoxelMask one;
  one.set(0);
  map.add_evidence({0, 0, 0}, one, {}, 1, 1);
  EXPECT_NE(before, content_id_of(encode_map(map, kInfo)));
}

TEST(MapFile, EveryTruncationAndEveryFlippedByteIsRefused) {
  const Bytes bytes = encode_map(testing::random_map(35, 3), kInfo);
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    EXPECT_FALSE(decode_map(std::span{bytes}.first(i), "map", {})) << "cut at " << i;
    Bytes flipped = bytes;
    flipped[i] = static_cast<std::uint8_t>(~flipped[i]);
    EXPECT_FALSE(decode_map(flipped, "map", {})) << "flipped at " << i;
  }
  Bytes longer = bytes;
  longer.push_back(0);
  expect_refused(longer, "too many");
}

TEST(MapFile, TwoThousandCorruptionsAreRefused) {
  const unsigned seed = 36;
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937 random{seed};
  const Bytes bytes = encode_map(testing::random_map(37, 30, 40), kInfo);
  for (int i = 0; i < 2000; ++i) {
    const Bytes bad = testing::corrupted(bytes, random);
    const auto loaded = decode_map(bad, "map", {});
    EXPECT_EQ(loaded.has_value(), bad == bytes) << "corruption " << i;
  }
}

TEST(MapFile, TwoThousandForgeriesWithGoodChecksumsStayWithinTheLimits) {
  const unsigned seed = 38;
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937 random{seed};
  const Bytes bytes = encode_map(testing::random_map(39, 30, 40), kInfo);
  ASSERT_EQ(testing::resealed_map(bytes), bytes);
  const MapLimits limits{std::size_t{1} << 20};
  int taken = 0;
  for (int i = 0; i < 2000; ++i) {
    const auto loaded =
        decode_map(testing::resealed_map(testing::corrupted(bytes, random)), "map", {}, limits);
    if (!loaded) continue;
    EXPECT_LE(loaded->map.bytes(), limits.max_bytes);
    EXPECT_GT(loaded->map.resolution_m(), 0);
    ++taken;
  }
  EXPECT_GT(taken, 0);  // a changed utime or evidence is a good map
}

TEST(MapFile, SaysWhatIsWrong) {
  const Bytes good = encode_map(testing::random_map(40, 30, 40), kInfo);
  expect_refused({}, "not a cairn map");
  expect_refused(Bytes(100, 'x'), "not a cairn map");
  Bytes bytes = good;
  testing::put_number_at<std::uint32_t>(bytes, 8, 2);
  expect_refused(bytes, "version 2");
  bytes = good;
  testing::put_number_at(bytes, 12, std::numeric_limits<double>::quiet_NaN());
  expect_refused(bytes, "header does not match its checksum");
  expect_refused(testing::resealed_map(bytes), "resolution");
  bytes = good;
  testing::put_number_at<std::uint64_t>(bytes, 44, std::uint64_t{1} << 60);
  expect_refused(testing::resealed_map(bytes), "more than");
  bytes = good;
  testing::put_number_at<std::uint64_t>(bytes, 36,
                                        3 + testing::number_at<std::uint64_t>(bytes, 44));
  expect_refused(testing::resealed_map(bytes), "more than");
  bytes = good;
  testing::put_number_at<std::uint32_t>(bytes, 72, 0xffffffff);
  expect_refused(testing::resealed_map(bytes), "tile 0 of");
  bytes = good;
  testing::put_number_at<std::int32_t>(bytes, 60, kTileLimit);
  expect_refused(testing::resealed_map(bytes), "outside the limits");
  bytes = good;
  testing::put_number_at<std::int32_t>(bytes, 60, kTileLimit - 1);
  expect_refused(testing::resealed_map(bytes), "out of order");
}

TEST(MapFile, AFileThatIsNotThereOrTooLargeIsNamed) {
  const cairn::testing::TemporaryFolder folder;
  const auto path = folder.path() / "none.cairn";
  const auto missing = load_map(path, {});
  ASSERT_FALSE(missing);
  EXPECT_NE(missing.error().message.find("none.cairn"), std::string::npos);
  ASSERT_TRUE(save_map(path, testing::random_map(41, 100), kInfo));
  const auto large = load_map(path, {}, MapLimits{1000});
  ASSERT_FALSE(large);
  EXPECT_NE(large.error().message.find("none.cairn"), std::string::npos);
  EXPECT_FALSE(save_map(folder.path() / "no" / "folder" / "map.cairn", VoxelMap{0.01}, kInfo));
}

TEST(MapId, TellsCalibrationsAndFirstFramesApart) {
  EXPECT_EQ(make_map_id(1, 2), make_map_id(1, 2));
  EXPECT_NE(make_map_id(1, 2), make_map_id(2, 1));
  EXPECT_NE(make_map_id(1, 2), make_map_id(1, 3));
  EXPECT_NE(make_map_id(0, 0), 0u);
}

}  // namespace
}  // namespace cairn::mapping
