// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <chrono>
#include <opencv2/imgcodecs.hpp>
#include <random>

#include "data_folder.hpp"
#include "messages/disparity_messages.hpp"
#include "messages/disparity_packing.hpp"
#include "messages/geometry_messages.hpp"
#include "stereo/matcher.hpp"

namespace cairn::messages {
namespace {

bool equal(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && cv::norm(a, b, cv::NORM_INF) == 0;
}

stereo::RectifiedCamera camera_of(int width_px, int height_px) {
  stereo::RectifiedCamera camera;
  camera.f_px = 554.25;
  camera.cx_px = 319.7;
  camera.cy_px = 239.1;
  camera.doffs_px = 0.3;
  camera.baseline_m = 0.254;
  camera.width_px = width_px;
  camera.height_px = height_px;
  camera.T_body_camera.linear() = R_body_camera_forward();
  camera.T_body_camera.translation() = Eigen::Vector3d(0.1, 0.127, 0.3);
  return camera;
}

/// Slanted surfaces with steps, holes and codes; `wildness` 1 makes every point a number of its
/// own.
stereo::DisparityImage image_of(int rows, int columns, double wildness, std::uint64_t seed) {
  std::mt19937_64 rng(seed);
  stereo::DisparityImage image;
  image.utime = 123'456;
  image.step_px = 2;
  image.camera = camera_of(2 * columns, 2 * rows);
  image.disparity_16ths.create(rows, columns);
  image.code.create(rows, columns);
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const bool wild = static_cast<double>(rng() % 1000) < 1000 * wildness;
      const int smooth = 200 + column + 2 * row + (column / 20 % 2) * 300;
      const bool hole = (row / 7 + column / 9) % 5 == 0;
      image.disparity_16ths(row, column) =
          static_cast<std::uint16_t>(wild ? rng() : static_cast<std::uint64_t>(hole ? 0 : smooth));
      image.code(row, column) = static_cast<std::uint8_t>(wild ? rng() % 4 : 3);
    }
  }
  return image;
}

void expect_round_trip(const stereo::DisparityImage& image) {
  const auto message = to_message(image, 99);
  ASSERT_TRUE(message) << message.error().message;
  EXPECT_TRUE(message->counts_agree());
  const auto back = to_disparity(*message);
  ASSERT_TRUE(back) << back.error().message;
  EXPECT_TRUE(equal(back->disparity_16ths, image.disparity_16ths));
  EXPECT_TRUE(equal(back->code, image.code));
  EXPECT_EQ(back->utime, image.utime);
  EXPECT_EQ(back->step_px, image.step_px);
  EXPECT_EQ(back->camera.f_px, image.camera.f_px);
  EXPECT_EQ(back->camera.cx_px, image.camera.cx_px);
  EXPECT_EQ(back->camera.cy_px, image.camera.cy_px);
  EXPECT_EQ(back->camera.doffs_px, image.camera.doffs_px);
  EXPECT_EQ(back->camera.baseline_m, image.camera.baseline_m);
  EXPECT_EQ(back->camera.width_px, image.camera.width_px);
  EXPECT_EQ(back->camera.height_px, image.camera.height_px);
  EXPECT_EQ(back->camera.T_body_camera.matrix(), image.camera.T_body_camera.matrix());
}

TEST(DisparityMessages, APlainGridIsTakenAsItStands) {
  const std::vector<std::uint8_t> plain{0, 0x34, 0x12, 0, 0, 3, 2};
  const auto grid = unpack(plain, 1, 2);
  ASSERT_TRUE(grid) << grid.error().message;
  EXPECT_EQ(grid->disparity_16ths(0, 0), 0x1234);
  EXPECT_EQ(grid->disparity_16ths(0, 1), 0);
  EXPECT_EQ(grid->code(0, 0), 3);
  EXPECT_EQ(grid->code(0, 1), 2);
  EXPECT_FALSE(unpack(plain, 2, 2)) << "too few bytes";
  EXPECT_FALSE(unpack(plain, 0, 0));
  EXPECT_FALSE(unpack(std::vector<std::uint8_t>{0, 1, 0, 4}, 1, 1)) << "a code over 3";
}

TEST(DisparityMessages, EveryGridComesBackExactly) {
  for (const auto& [rows, columns] :
       {std::pair{1, 1}, {1, 8}, {9, 1}, {2, 3}, {31, 17}, {90, 120}}) {
    for (const double wildness : {0.0, 0.02, 0.5, 1.0}) {
      expect_round_trip(image_of(rows, columns, wildness, 5));
    }
  }
}

TEST(DisparityMessages, AnEmptyAndAFullGridComeBackExactly) {
  auto image = image_of(40, 50, 0, 1);
  for (const int value : {0, 1, 65535}) {
    image.disparity_16ths.setTo(value);
    for (const int code : {0, 3}) {
      image.code.setTo(code);
      expect_round_trip(image);
    }
  }
}

TEST(DisparityMessages, AnOddImageSizeComesBackExactly) {
  auto image = image_of(188, 225, 0.02, 3);
  image.camera = camera_of(449, 375);
  expect_round_trip(image);
}

TEST(DisparityMessages, TheSameGridGivesTheSameBytes) {
  const auto image = image_of(90, 120, 0.3, 8);
  EXPECT_EQ(to_message(image, 1)->packed, to_message(image, 1)->packed);
}

TEST(DisparityMessages, ABandIsAnImageOfItsOwn) {
  const auto whole = image_of(60, 80, 0.1, 2);
  const auto band = to_disparity(to_band_message(whole, 1, 20, 15).value());
  ASSERT_TRUE(band) << band.error().message;
  EXPECT_TRUE(equal(band->disparity_16ths, whole.disparity_16ths.rowRange(20, 35)));
  EXPECT_TRUE(equal(band->code, whole.code.rowRange(20, 35)));
  EXPECT_EQ(band->camera.height_px, 30);
  for (int row = 0; row < 15; ++row) {
    for (int column = 0; column < 80; ++column) {
      if (!band->valid(row, column)) continue;
      ASSERT_LT((band->point_camera(row, column) - whole.point_camera(row + 20, column)).norm(),
                1e-12 * whole.depth_m(row + 20, column));
    }
  }
  EXPECT_FALSE(to_band_message(whole, 1, 50, 11));
  EXPECT_FALSE(to_band_message(whole, 1, -1, 5));
  EXPECT_FALSE(to_band_message(whole, 1, 0, 0));
  EXPECT_FALSE(to_band_message(whole, 1, 5, 2147483647));
}

TEST(DisparityMessages, WhatDoesNotFitIsRefusedWithItsSize) {
  const auto message = to_message(image_of(480, 640, 1, 4), 1);
  ASSERT_FALSE(message);
  EXPECT_NE(message.error().message.find("the limit is 115000; send a coarser grid or fewer rows"),
            std::string::npos);
}

TEST(DisparityMessages, WhatDoesNotAddUpIsRefusedByName) {
  const auto good = to_message(image_of(30, 40, 0.1, 6), 1).value();
  const auto error = [](const disparity_t& message) {
    const auto image = to_disparity(message);
    return image ? std::string("none") : image.error().message;
  };
  ASSERT_EQ(error(good), "none");
  auto bad = good;
  bad.columns = 39;
  EXPECT_EQ(error(bad), "DISPARITY packed: packed grid is 40x30, message says 39x30");
  bad = good;
  bad.step_px = 0;
  EXPECT_EQ(error(bad), "DISPARITY step_px: 0 is out of range");
  bad = good;
  bad.step_px = 3;
  EXPECT_EQ(error(bad), "DISPARITY rows, columns: the grid reaches beyond its camera's image");
  bad = good;
  bad.rows = -1;
  EXPECT_NE(error(bad).find("DISPARITY rows, columns: -1"), std::string::npos);
  bad = good;
  bad.camera.f_px = 0;
  EXPECT_EQ(error(bad), "DISPARITY camera.f_px: is not a positive number");
  bad = good;
  bad.camera.doffs_px = NAN;
  EXPECT_EQ(error(bad), "DISPARITY camera: cx, cy or doffs is not finite");
  bad = good;
  bad.camera.T_body_camera = isometry_t{};
  EXPECT_NE(error(bad).find("DISPARITY camera.T_body_camera"), std::string::npos);
  bad = good;
  bad.packed[0] = 2;
  EXPECT_EQ(error(bad), "DISPARITY packed: packed in version 2, this program knows 1");
  bad = good;
  bad.packed.push_back(0);
  EXPECT_EQ(error(bad), "DISPARITY packed: bytes after the end of the packed grid");
  bad = good;
  bad.packed.resize(bad.packed.size() - 1);
  EXPECT_EQ(error(bad), "DISPARITY packed: a packed stream is damaged or ends too early");
  bad.packed.clear();
  EXPECT_EQ(error(bad), "DISPARITY packed: packed bytes end too early");

  auto image = image_of(30, 40, 0.1, 6);
  image.code(3, 3) = 4;
  EXPECT_EQ(to_message(image, 1).error().message, "DISPARITY: a code is over 3");
}

TEST(DisparityPacking, AStreamThatClaimsTooMuchIsRefusedBeforeItIsUnpacked) {
  Bytes packed{1, 8, 0, 8, 0, 0, 0, 0, 0};
  StreamWriter(packed, Redundancy::kRepeated).append(Bytes(100'000'000));
  ASSERT_LT(packed.size(), 20'000U);
  EXPECT_EQ(unpack(packed, 8, 8).error().message,
            "a stream says that it unpacks to 100000000 bytes, more than can belong here");
}

struct RealPair {
  std::string name;
  std::string left;
  std::string right;
  cv::Size crop;
  int max_disparity_px;
  int limit_bytes;
};

TEST(DisparityPacking, SizeAndTimeOnRealPairs) {
  const auto data = testing::data_folder();
  if (!data) GTEST_SKIP() << "no real images: set CAIRN_DATA";
  const std::vector<RealPair> pairs{{"motorcycle",
                                     "stereo/gt/motorcycle/left.png",
                                     "stereo/gt/motorcycle/right.png",
                                     {640, 480},
                                     64,
                                     35'000},
                                    {"adirondack",
                                     "stereo/gt/adirondack/left.png",
                                     "stereo/gt/adirondack/right.png",
                                     {640, 480},
                                     64,
                                     35'000},
                                    {"kitti_1 first",
                                     "sequence/kitti_1/image_l/000000.png",
                                     "sequence/kitti_1/image_r/000000.png",
                                     {1226, 370},
                                     128,
                                     60'000},
                                    {"kitti_1 last",
                                     "sequence/kitti_1/image_l/000050.png",
                                     "sequence/kitti_1/image_r/000050.png",
                                     {1226, 370},
                                     128,
                                     60'000}};
  for (const RealPair& pair : pairs) {
    cv::Mat left = cv::imread(*data / pair.left, cv::IMREAD_GRAYSCALE);
    cv::Mat right = cv::imread(*data / pair.right, cv::IMREAD_GRAYSCALE);
    if (left.empty()) continue;
    left = left(cv::Rect({0, 0}, pair.crop)).clone();
    right = right(cv::Rect({0, 0}, pair.crop)).clone();
    for (const char* variant : {"3way", "hh"}) {
      stereo::MatcherConfig config;
      config.variant = variant;
      config.max_disparity_px = pair.max_disparity_px;
      config.downscale = 1;
      const auto image = stereo::make_matcher(config).value()->match(
          left, right, camera_of(pair.crop.width, pair.crop.height), 1);
      ASSERT_TRUE(image) << image.error().message;
      const auto start = std::chrono::steady_clock::now();
      const auto message = to_message(*image, 1);
      const auto encoded = std::chrono::steady_clock::now();
      ASSERT_TRUE(message) << message.error().message;
      ASSERT_TRUE(to_disparity(*message));
      const auto decoded = std::chrono::steady_clock::now();
      using Milliseconds = std::chrono::duration<double, std::milli>;
      const int size_bytes = message->getEncodedSize();
      std::printf("%s %s: %dx%d, %.0f %% valid, %d bytes, encode %.2f ms, decode %.2f ms\n",
                  pair.name.c_str(), variant, image->cols(), image->rows(),
                  100.0 * cv::countNonZero(image->disparity_16ths) /
                      static_cast<double>(image->code.total()),
                  size_bytes, Milliseconds(encoded - start).count(),
                  Milliseconds(decoded - encoded).count());
      EXPECT_LE(size_bytes, pair.limit_bytes) << pair.name << " " << variant;
      expect_round_trip(*image);
    }
  }
}

}  // namespace
}  // namespace cairn::messages
