// SPDX-License-Identifier: Apache-2.0
#include "stereo/matcher.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>

#include "texture.hpp"

namespace cairn::stereo {
namespace {

RectifiedCamera camera_of(cv::Size size) {
  RectifiedCamera camera;
  camera.f_px = 554;
  camera.cx_px = 0.5 * (size.width - 1);
  camera.cy_px = 0.5 * (size.height - 1);
  camera.baseline_m = 0.254;
  camera.width_px = size.width;
  camera.height_px = size.height;
  return camera;
}

/// The disparity of left pixel (u, v): a plane that leans both ways.
struct SlantedPlane {
  double at_origin_px = 20;
  double per_u = 0.03;
  double per_v = 0.02;

  [[nodiscard]] double disparity_px(double u, double v) const {
    return at_origin_px + per_u * u + per_v * v;
  }
  /// The left column that the right camera sees at column x.
  [[nodiscard]] double left_column(double x, double v) const {
    return (x + at_origin_px + per_v * v) / (1 - per_u);
  }
};

struct Pair {
  cv::Mat_<std::uint8_t> left;
  cv::Mat_<std::uint8_t> right;
};

/// Grey values by area: the mean of 4x4 samples per pixel.
template <class Function>
std::uint8_t pixel_mean(double u, double v, Function&& grey) {
  double sum = 0;
  for (int j = 0; j < 4; ++j) {
    for (int i = 0; i < 4; ++i) sum += grey(u + (i - 1.5) / 4, v + (j - 1.5) / 4);
  }
  return static_cast<std::uint8_t>(std::lround(sum / 16));
}

Pair render(const SlantedPlane& plane, cv::Size size) {
  Pair pair{cv::Mat_<std::uint8_t>(size), cv::Mat_<std::uint8_t>(size)};
  const auto grey = [](double u, double v) { return testing::surface_grey(u, v, 4, 5); };
  for (int v = 0; v < size.height; ++v) {
    for (int u = 0; u < size.width; ++u) {
      pair.left(v, u) = pixel_mean(u, v, grey);
      pair.right(v, u) =
          pixel_mean(u, v, [&](double x, double y) { return grey(plane.left_column(x, y), y); });
    }
  }
  return pair;
}

/// `name` is sgm, or one of OpenCV's variants.
MatcherConfig config_of(const std::string& name, int downscale, int output_step_px) {
  MatcherConfig config;
  if (name == "sgm") {
    config.method = name;
  } else {
    config.variant = name;
  }
  config.downscale = downscale;
  config.output_step_px = output_step_px;
  config.max_disparity_px = 64;
  return config;
}

DisparityImage match(const MatcherConfig& config, const Pair& pair) {
  auto matcher = make_matcher(config);
  EXPECT_TRUE(matcher) << (matcher ? "" : matcher.error().message);
  auto image = (*matcher)->match(pair.left, pair.right, camera_of(pair.left.size()), 42);
  EXPECT_TRUE(image) << (image ? "" : image.error().message);
  return std::move(*image);
}

bool identical(const DisparityImage& a, const DisparityImage& b) {
  return a.disparity_16ths.size() == b.disparity_16ths.size() &&
         cv::countNonZero(a.disparity_16ths != b.disparity_16ths) == 0 &&
         cv::countNonZero(a.code != b.code) == 0;
}

struct Bias {
  double mean_px = 0;
  double density = 0;
};

/// Compares every answer with the plane at the place that the result's own camera says it belongs
/// to.
Bias bias_of(const DisparityImage& image, const SlantedPlane& plane, const RectifiedCamera& full) {
  double sum = 0;
  int answers = 0;
  for (int row = 0; row < image.rows(); ++row) {
    for (int col = 0; col < image.cols(); ++col) {
      if (!image.valid(row, col)) continue;
      // The direction that the result claims, as a pixel of the full image.
      const Eigen::Vector3d p = image.point_camera(row, col);
      const double u = full.f_px * p.x() / p.z() + full.cx_px;
      const double v = full.f_px * p.y() / p.z() + full.cy_px;
      const double truth_px = plane.disparity_px(u, v);
      sum += image.disparity_px(row, col) - truth_px;
      ++answers;
    }
  }
  return {sum / answers,
          static_cast<double>(answers) / static_cast<double>(image.disparity_16ths.total())};
}

TEST(Matcher, HalfSizeMatchingIsNotOffByHalfAPixel) {
  // A slip of the grid by half a pixel would show as 0.5 * (per_u + per_v) = 0.09 px, but only on a
  // slope. `hh` is the variant to see it with: its paths come from all sides, where those of 3way
  // pull a slope towards the row above.
  const SlantedPlane steep{5, 0.06, 0.12};
  const cv::Size size{320, 240};
  const Pair pair = render(steep, size);
  for (const auto& [downscale, step] : {std::pair{1, 1}, {1, 2}, {2, 2}}) {
    SCOPED_TRACE("downscale " + std::to_string(downscale) + " step " + std::to_string(step));
    const auto image = match(config_of("hh", downscale, step), pair);
    const Bias bias = bias_of(image, steep, camera_of(size));
    EXPECT_LT(std::abs(bias.mean_px), 0.03);
    EXPECT_GT(bias.density, 0.8);
    EXPECT_EQ(image.step_px, step);
  }
}

TEST(Matcher, EveryVariantFindsThePlane) {
  const SlantedPlane plane;
  const cv::Size size{320, 240};
  const Pair pair = render(plane, size);
  for (const char* variant : {"bm", "3way", "sgbm", "hh", "hh4", "sgm"}) {
    for (const int downscale : {1, 2}) {
      SCOPED_TRACE(std::string(variant) + " downscale " + std::to_string(downscale));
      const auto image = match(config_of(variant, downscale, 2), pair);
      const Bias bias = bias_of(image, plane, camera_of(size));
      EXPECT_LT(std::abs(bias.mean_px), 0.1);
      EXPECT_GT(bias.density, 0.6);
      EXPECT_EQ(image.utime, 42);
    }
  }
}

TEST(Matcher, ASlopedFloorIsTrustedLikeAWall) {
  // A floor 0.3 m below a rig of 0.254 m baseline gains 0.85 px of disparity per row.
  for (const SlantedPlane& plane : {SlantedPlane{20, 0, 0}, {0, 0, 0.5}}) {
    const auto image = match(config_of("hh", 1, 1), render(plane, {320, 120}));
    const cv::Rect middle{80, 30, 220, 60};
    const cv::Mat trusted = (image.code(middle) >= 2) & (image.disparity_16ths(middle) > 0);
    EXPECT_GT(cv::countNonZero(trusted), 0.7 * middle.area());
  }
}

TEST(Matcher, SecondPixelsAreThoseOfTheFullResult) {
  const Pair pair = render(SlantedPlane{}, {321, 239});
  const auto full = match(config_of("3way", 1, 1), pair);
  const auto second = match(config_of("3way", 1, 2), pair);
  ASSERT_EQ(second.rows(), 120);
  ASSERT_EQ(second.cols(), 161);
  for (int row = 0; row < second.rows(); ++row) {
    for (int col = 0; col < second.cols(); ++col) {
      ASSERT_EQ(second.disparity_16ths(row, col), full.disparity_16ths(2 * row, 2 * col));
      ASSERT_EQ(second.code(row, col), full.code(2 * row, 2 * col));
    }
  }
  const auto half = match(config_of("3way", 2, 2), pair);
  EXPECT_EQ(half.disparity_16ths.size(), second.disparity_16ths.size());
  EXPECT_DOUBLE_EQ(half.camera.cx_px, second.camera.cx_px - 0.5);
  EXPECT_DOUBLE_EQ(half.camera.cy_px, second.camera.cy_px - 0.5);
}

TEST(Matcher, GivesTheSameBytesAgainAndOnTwoThreads) {
  const Pair pair = render(SlantedPlane{}, {400, 300});
  const Pair other = render(SlantedPlane{30, -0.01, 0.01}, {400, 300});
  const int threads = cv::getNumThreads();
  for (const char* variant : {"bm", "3way", "sgbm", "hh", "hh4", "sgm"}) {
    SCOPED_TRACE(variant);
    const auto config = config_of(variant, 1, 1);
    cv::setNumThreads(1);
    const auto single = match(config, pair);
    cv::setNumThreads(2);
    EXPECT_TRUE(identical(single, match(config, pair)));
    const auto matcher = make_matcher(config);
    ASSERT_TRUE((*matcher)->match(other.left, other.right, camera_of({400, 300}), 1));
    const auto later = (*matcher)->match(pair.left, pair.right, camera_of({400, 300}), 2);
    ASSERT_TRUE(later);
    EXPECT_TRUE(identical(single, *later)) << "remembers an earlier pair";
  }
  cv::setNumThreads(threads);
}

TEST(Matcher, TellsPlainSurfacesFromTexturedOnes) {
  Pair pair = render(SlantedPlane{20, 0, 0}, {320, 240});
  const cv::Rect plain{140, 60, 120, 120};
  pair.left(plain) = 120;
  pair.right(plain - cv::Point(20, 0)) = 120;
  const auto image = match(config_of("bm", 1, 1), pair);
  int low_texture = 0;
  int inside = 0;
  for (int row = plain.y + 10; row < plain.y + 110; ++row) {
    for (int col = plain.x + 10; col < plain.x + 110; ++col) {
      if (image.valid(row, col)) {
        EXPECT_LE(image.code(row, col), 2);
        continue;
      }
      ++inside;
      low_texture += image.code(row, col) == static_cast<int>(Reason::kLowTexture) ? 1 : 0;
    }
  }
  EXPECT_GT(inside, 5000);
  EXPECT_GT(low_texture, 0.95 * inside);
}

TEST(Matcher, SaysNoDataWhereTheRightImageEnds) {
  const Pair pair = render(SlantedPlane{40, 0, 0}, {320, 240});
  const auto image = match(config_of("3way", 1, 1), pair);
  int no_data = 0;
  for (int row = 20; row < 220; ++row) {
    for (int col = 0; col < 36; ++col) {
      EXPECT_FALSE(image.valid(row, col)) << row << " " << col;
      no_data += image.code(row, col) == static_cast<int>(Reason::kNoData) ? 1 : 0;
    }
    for (int col = 48; col < 300; ++col) EXPECT_TRUE(image.valid(row, col)) << row << " " << col;
  }
  EXPECT_GT(no_data, 0.5 * 200 * 36);
}

TEST(Matcher, AnswersAreWithinTheRangeSearched) {
  const Pair near = render(SlantedPlane{80, 0, 0}, {320, 240});
  auto config = config_of("3way", 1, 1);
  config.min_disparity_px = 16;
  for (const Pair& pair : {near, render(SlantedPlane{6, 0, 0}, {320, 240})}) {
    const auto image = match(config, pair);
    for (int row = 0; row < image.rows(); ++row) {
      for (int col = 0; col < image.cols(); ++col) {
        if (!image.valid(row, col)) continue;
        ASSERT_GT(image.disparity_px(row, col), 16);
        ASSERT_LT(image.disparity_px(row, col), 63);
      }
    }
  }
}

TEST(Matcher, RefusesBadImages) {
  const auto matcher = make_matcher(MatcherConfig{});
  ASSERT_TRUE(matcher);
  const auto refuses = [&](const cv::Mat& left, const cv::Mat& right, cv::Size size) {
    const auto image = (*matcher)->match(left, right, camera_of(size), 0);
    return !image && !image.error().message.empty();
  };
  const cv::Mat grey = cv::Mat::zeros(240, 320, CV_8UC1);
  EXPECT_TRUE(refuses(cv::Mat(), cv::Mat(), {320, 240}));
  EXPECT_TRUE(refuses(grey, cv::Mat(), {320, 240}));
  EXPECT_TRUE(refuses(grey, cv::Mat::zeros(240, 322, CV_8UC1), {320, 240}));
  EXPECT_TRUE(refuses(grey, grey, {640, 480}));
  EXPECT_TRUE(
      refuses(cv::Mat::zeros(240, 320, CV_8UC3), cv::Mat::zeros(240, 320, CV_8UC3), {320, 240}));
  EXPECT_TRUE(
      refuses(cv::Mat::zeros(240, 320, CV_16UC1), cv::Mat::zeros(240, 320, CV_16UC1), {320, 240}));
  EXPECT_TRUE(refuses(cv::Mat::zeros(20, 20, CV_8UC1), cv::Mat::zeros(20, 20, CV_8UC1), {20, 20}));
  EXPECT_FALSE(refuses(grey, grey, {320, 240})) << "the matcher must stay usable";
}

TEST(Matcher, WorksOnImagesNarrowerThanTheRange) {
  std::mt19937 random(3);
  cv::Mat_<std::uint8_t> noise(70, 66);
  for (auto& pixel : noise) pixel = static_cast<std::uint8_t>(random());
  for (const char* variant : {"bm", "3way", "sgbm", "hh", "hh4"}) {
    MatcherConfig config = config_of(variant, 2, 2);
    config.max_disparity_px = 1024;
    const auto image = match(config, {noise, noise});
    EXPECT_EQ(image.disparity_16ths.size(), cv::Size(33, 35));
  }
}

TEST(Matcher, RefusesSettingsThatMakeNoSense) {
  const auto refused = [](auto&& change) {
    MatcherConfig config;
    change(config);
    return !make_matcher(config);
  };
  EXPECT_TRUE(refused([](MatcherConfig& c) { c.method = "tea leaves"; }));
  EXPECT_TRUE(refused([](MatcherConfig& c) { c.variant = "4way"; }));
  EXPECT_TRUE(refused([](MatcherConfig& c) { c.min_disparity_px = c.max_disparity_px; }));
  EXPECT_TRUE(refused([](MatcherConfig& c) { c.output_step_px = 1; }));
  EXPECT_TRUE(refused([](MatcherConfig& c) { c.downscale = 3; }));
  EXPECT_FALSE(refused([](MatcherConfig&) {}));
}

}  // namespace
}  // namespace cairn::stereo
