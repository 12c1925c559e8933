// SPDX-License-Identifier: Apache-2.0
#include "stereo/path_aggregation.hpp"

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "stereo/census.hpp"

namespace cairn::stereo {
namespace {

/// The same matching in whole numbers, pixel by pixel, straight from the definition.
class PlainMatching {
 public:
  PlainMatching(const cv::Mat& left, const cv::Mat& right, const SearchRange& range,
                const Penalties& penalties)
      : left_{left}, right_{right}, range_{range}, penalties_{penalties} {}

  Winners run() {
    winners_.create(left_.size());
    sweep(0, 1, left_.rows / 2);
    sweep(left_.rows - 1, -1, left_.rows - left_.rows / 2);
    return winners_;
  }

 private:
  using Support = std::vector<int>;

  [[nodiscard]] std::size_t count() const {
    return static_cast<std::size_t>(range_.end_px - range_.min_px);
  }

  static int grey(const cv::Mat& image, int x, int y) {
    return image.at<std::uint8_t>(std::clamp(y, 0, image.rows - 1),
                                  std::clamp(x, 0, image.cols - 1));
  }

  static int gradient_level(const cv::Mat& image, int x, int y) {
    const auto column = [&](int at) {
      const int ends = (grey(image, at, y - 1) + grey(image, at, y + 1) + 1) / 2;
      return (ends + grey(image, at, y) + 1) / 2;
    };
    const int gradient = column(x + 1) - column(x - 1);
    int level = 0;
    for (const int reach : kGradientSteps_grey) {
      if (gradient >= reach) ++level;
      if (gradient <= -reach) --level;
    }
    return level;
  }

  [[nodiscard]] int cost(int x, int y, std::size_t d) const {
    const int x_right = x - range_.min_px - static_cast<int>(d);
    int sum =
        std::min(kMaxGradientCost, kGradientWeight * std::abs(gradient_level(left_, x, y) -
                                                              gradient_level(right_, x_right, y)));
    for (const auto& [dx, dy] : kCensusNeighbours) {
      const bool here = grey(left_, x + dx, y + dy) > grey(left_, x, y);
      const bool there = grey(right_, x_right + dx, y + dy) > grey(right_, x_right, y);
      if (here != there) sum += kCensusWeight;
    }
    return sum;
  }

  [[nodiscard]] int jump(int grey_a, int grey_b) const {
    return std::max(
        penalties_.by_more_at_least,
        penalties_.by_more_at_most - penalties_.by_more_per_grey * std::abs(grey_a - grey_b));
  }

  [[nodiscard]] Support step(const Support& before, int x, int y, int by_one, int jump_next) const {
    Support dearness(count());
    for (std::size_t d = 0; d < count(); ++d) {
      int best = std::max(before[d], 0);
      if (d > 0) best = std::max(best, before[d - 1] - by_one);
      if (d + 1 < count()) best = std::max(best, before[d + 1] - by_one);
      dearness[d] = cost(x, y, d) - best;
    }
    const int least = *std::min_element(dearness.begin(), dearness.end());
    Support support(count());
    for (std::size_t d = 0; d < count(); ++d) {
      support[d] = std::max(0, least + jump_next - dearness[d]);
    }
    return support;
  }

  void sweep(int first, int down, int rows) {
    const std::size_t cols = static_cast<std::size_t>(left_.cols);
    std::vector<Support> across(cols, Support(count(), 0));
    for (int i = 0; i < rows; ++i) {
      const int y = first + i * down;
      std::vector<Support> sum(cols, Support(count(), 0));
      const auto add = [&](int x, const Support& support) {
        for (std::size_t d = 0; d < count(); ++d) sum[static_cast<std::size_t>(x)][d] += support[d];
      };
      Support path(count(), 0);
      for (int x = 0; x < left_.cols; ++x) {
        const int next = x + 1 < left_.cols ? jump(grey(left_, x, y), grey(left_, x + 1, y))
                                            : penalties_.by_more_at_most;
        path = step(path, x, y, penalties_.by_one_along_row, next);
        add(x, path);
      }
      path.assign(count(), 0);
      for (int x = left_.cols - 1; x >= 0; --x) {
        path = step(path, x, y, penalties_.by_one_along_row,
                    jump(grey(left_, x, y), grey(left_, x - 1, y)));
        add(x, path);
      }
      for (int x = 0; x < left_.cols; ++x) {
        Support& column = across[static_cast<std::size_t>(x)];
        column = step(column, x, y, penalties_.by_one_across_rows,
                      jump(grey(left_, x, y), grey(left_, x, y + down)));
        add(x, column);
      }
      for (int x = 0; x < left_.cols; ++x) choose(x, y, sum);
    }
  }

  void choose(int x, int y, const std::vector<Support>& sum) {
    const Support& here = sum[static_cast<std::size_t>(x)];
    const auto best =
        static_cast<std::size_t>(std::max_element(here.begin(), here.end()) - here.begin());
    int runner_up = 0;
    int right = 0;
    for (std::size_t d = 0; d < count(); ++d) {
      if (d + 1 < best || d > best + 1) runner_up = std::max(runner_up, here[d]);
      const std::size_t x_left = static_cast<std::size_t>(x) + d;
      if (x_left < sum.size()) right = std::max(right, sum[x_left][d]);
    }
    const auto byte = [](int value) { return static_cast<std::uint8_t>(value); };
    winners_.index(y, x) = static_cast<std::uint8_t>(best);
    winners_.support(y, x) = byte(here[best]);
    winners_.below(y, x) = byte(best > 0 ? here[best - 1] : 0);
    winners_.above(y, x) = byte(best + 1 < count() ? here[best + 1] : 0);
    winners_.runner_up(y, x) = byte(runner_up);
    winners_.right_support(y, x) = byte(right);
  }

  cv::Mat left_;
  cv::Mat right_;
  SearchRange range_;
  Penalties penalties_;
  Winners winners_;
};

void expect_identical(const Winners& a, const Winners& b) {
  EXPECT_EQ(cv::countNonZero(a.index != b.index), 0);
  EXPECT_EQ(cv::countNonZero(a.support != b.support), 0);
  EXPECT_EQ(cv::countNonZero(a.below != b.below), 0);
  EXPECT_EQ(cv::countNonZero(a.above != b.above), 0);
  EXPECT_EQ(cv::countNonZero(a.runner_up != b.runner_up), 0);
  EXPECT_EQ(cv::countNonZero(a.right_support != b.right_support), 0);
}

/// Noise, slightly smoothed; where there is room the right image is the left one, 20 px further.
std::pair<cv::Mat, cv::Mat> noisy_pair(cv::Size size, std::mt19937& random) {
  cv::Mat images[2];
  for (cv::Mat& image : images) {
    image.create(size, CV_8UC1);
    for (int row = 0; row < size.height; ++row) {
      for (int col = 0; col < size.width; ++col) {
        image.at<std::uint8_t>(row, col) = static_cast<std::uint8_t>(random());
      }
    }
    cv::GaussianBlur(image, image, {3, 3}, 0.7);
  }
  if (size.width > 60) {
    const cv::Rect seen{20, 0, size.width - 20, size.height};
    images[0](seen).copyTo(images[1](seen - cv::Point(20, 0)));
  }
  return {images[0], images[1]};
}

struct Shape {
  cv::Size size;
  SearchRange range;
};

const std::vector<Shape> kShapes{{{70, 23}, {0, 32}},   {{97, 16}, {12, 52}}, {{65, 9}, {3, 67}},
                                 {{60, 11}, {12, 156}}, {{40, 7}, {0, 256}},  {{33, 5}, {100, 300}},
                                 {{17, 3}, {0, 16}},    {{5, 1}, {2, 72}},    {{100, 12}, {1, 97}},
                                 {{50, 8}, {0, 128}},   {{50, 8}, {0, 192}},  {{64, 5}, {7, 231}}};

class PathAggregationOn : public testing::TestWithParam<std::int64_t> {
 protected:
  void SetUp() override {
    if ((hwy::SupportedTargets() & GetParam()) == 0) GTEST_SKIP() << "this CPU cannot";
    hwy::SetSupportedTargetsForTest(GetParam());
  }
  void TearDown() override { hwy::SetSupportedTargetsForTest(0); }
};

TEST_P(PathAggregationOn, EveryPixelIsAsByTheDefinition) {
  std::mt19937 random(1);
  for (const auto& [size, range] : kShapes) {
    SCOPED_TRACE(std::to_string(size.width) + "x" + std::to_string(size.height) + " range " +
                 std::to_string(range.min_px) + " to " + std::to_string(range.end_px));
    const auto [left, right] = noisy_pair(size, random);
    const Winners truth = PlainMatching(left, right, range, Penalties{}).run();
    for (const int threads : {1, 2}) {
      Winners winners;
      aggregate_paths(left, right, range, Penalties{}, threads, winners);
      expect_identical(winners, truth);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Targets, PathAggregationOn,
                         testing::Values(HWY_AVX2, HWY_SSE4, HWY_EMU128), [](const auto& target) {
                           return target.param == HWY_AVX2   ? "Avx2"
                                  : target.param == HWY_SSE4 ? "Sse4"
                                                             : "Plain";
                         });

TEST(PathAggregation, TakesViewsOfLargerImages) {
  std::mt19937 random(2);
  const auto [left, right] = noisy_pair({120, 40}, random);
  const cv::Rect part{10, 5, 80, 30};
  Winners of_view;
  Winners of_copy;
  aggregate_paths(left(part), right(part), {0, 40}, Penalties{}, 1, of_view);
  aggregate_paths(left(part).clone(), right(part).clone(), {0, 40}, Penalties{}, 1, of_copy);
  expect_identical(of_view, of_copy);
}

}  // namespace
}  // namespace cairn::stereo
