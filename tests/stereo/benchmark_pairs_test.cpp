// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgcodecs.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "data_folder.hpp"
#include "stereo/disparity_png.hpp"
#include "stereo/matcher.hpp"

namespace cairn::stereo {
namespace {

struct Scene {
  cv::Mat left;
  cv::Mat right;
  cv::Mat_<float> truth_px;
  cv::Mat mask;  ///< 255 = evaluate

  [[nodiscard]] RectifiedCamera camera() const {
    RectifiedCamera camera;
    camera.f_px = 1000;
    camera.baseline_m = 0.1;
    camera.width_px = left.cols;
    camera.height_px = left.rows;
    return camera;
  }
};

std::optional<Scene> load_scene(const std::string& name) {
  const auto data = testing::data_folder();
  if (!data) return std::nullopt;
  const auto folder = *data / "stereo" / "gt" / name;
  auto truth = read_disparity_png_px(folder / "gt16.png");
  if (!truth) return std::nullopt;
  Scene scene;
  scene.left = cv::imread((folder / "left.png").string(), cv::IMREAD_GRAYSCALE);
  scene.right = cv::imread((folder / "right.png").string(), cv::IMREAD_GRAYSCALE);
  scene.truth_px = *truth;
  scene.mask = scene.truth_px > 0;
  const auto nonocc = folder / "mask_nonocc.png";
  if (std::filesystem::exists(nonocc)) {
    scene.mask &= cv::imread(nonocc.string(), cv::IMREAD_GRAYSCALE) == 255;
  }
  return scene;
}

struct Score {
  double bad2 = 0;
  double density = 0;
  double bad2_invalid = 0;
};

template <class Disparity>
Score score_of(const Scene& scene, Disparity&& disparity_px) {
  int judged = 0;
  int answered = 0;
  int bad = 0;
  for (int row = 0; row < scene.truth_px.rows; ++row) {
    for (int col = 0; col < scene.truth_px.cols; ++col) {
      if (scene.mask.at<std::uint8_t>(row, col) == 0) continue;
      ++judged;
      const double d_px = disparity_px(row, col);
      if (!(d_px > 0)) continue;
      ++answered;
      if (std::abs(d_px - static_cast<double>(scene.truth_px(row, col))) > 2) ++bad;
    }
  }
  return {static_cast<double>(bad) / answered, static_cast<double>(answered) / judged,
          static_cast<double>(bad + judged - answered) / judged};
}

/// `name` is sgm, or one of OpenCV's variants.
DisparityImage full_size_match(const Scene& scene, const std::string& name, int max_px) {
  MatcherConfig config;
  if (name == "sgm") {
    config.method = name;
    config.uniqueness_percent = 5;  // of a support that is high even where all is in doubt
  } else {
    config.variant = name;
  }
  config.downscale = 1;
  config.output_step_px = 1;
  config.max_disparity_px = max_px;
  auto matcher = make_matcher(config);
  EXPECT_TRUE(matcher);
  auto image = (*matcher)->match(scene.left, scene.right, scene.camera(), 0);
  EXPECT_TRUE(image);
  return std::move(*image);
}

Score score_of_image(const Scene& scene, const DisparityImage& image) {
  return score_of(scene, [&](int row, int col) {
    return image.valid(row, col) ? image.disparity_px(row, col) : 0.0;
  });
}

/// Straight from OpenCV, unpadded and unjudged, with the settings of the published table.
Score opencv_3way(const Scene& scene, int count) {
  const auto sgbm = cv::StereoSGBM::create(0, count, 5, 8 * 25, 32 * 25, 1, 31, 10, 100, 2,
                                           cv::StereoSGBM::MODE_SGBM_3WAY);
  cv::Mat_<std::int16_t> raw;
  sgbm->compute(scene.left, scene.right, raw);
  return score_of(scene, [&](int row, int col) { return raw(row, col) / 16.0; });
}

/// Pairs with truth, and how many disparities are searched in each.
constexpr std::array<std::pair<const char*, int>, 6> kPairs{{{"tsukuba", 16},
                                                             {"venus", 32},
                                                             {"teddy", 64},
                                                             {"cones", 64},
                                                             {"motorcycle", 64},
                                                             {"adirondack", 64}}};

TEST(BenchmarkPairs, ThreeWayIsAsGoodAsOpenCvsOwnAndDenser) {
  for (const auto& [name, count] : kPairs) {
    const auto scene = load_scene(name);
    if (!scene) GTEST_SKIP() << "the real stereo pairs are not here; set CAIRN_DATA";
    SCOPED_TRACE(name);
    const Score peer = opencv_3way(*scene, count);
    const Score ours = score_of_image(*scene, full_size_match(*scene, "3way", count));
    std::printf(
        "%-11s OpenCV 3way bad2 %4.1f density %4.1f bad2+invalid %4.1f | block 3way %4.1f %4.1f "
        "%4.1f\n",
        name, 100 * peer.bad2, 100 * peer.density, 100 * peer.bad2_invalid, 100 * ours.bad2,
        100 * ours.density, 100 * ours.bad2_invalid);
    EXPECT_LT(ours.bad2, peer.bad2 + 0.01);
    EXPECT_GT(ours.density, peer.density - 0.005);
    EXPECT_LT(ours.bad2_invalid, peer.bad2_invalid + 0.005);
  }
}

/// Mean shares over scenes.
struct MeanScore {
  Score sum;
  int scenes = 0;

  void add(const Score& score) {
    sum.bad2 += score.bad2;
    sum.bad2_invalid += score.bad2_invalid;
    ++scenes;
  }
  [[nodiscard]] double bad2() const { return sum.bad2 / scenes; }
  [[nodiscard]] double bad2_invalid() const { return sum.bad2_invalid / scenes; }
};

TEST(BenchmarkPairs, SgmIsWrongLessOftenThanThreeWayInTheMean) {
  MeanScore sgm;
  MeanScore three_way;
  for (const auto& [name, count] : kPairs) {
    const auto scene = load_scene(name);
    if (!scene) GTEST_SKIP() << "the real stereo pairs are not here; set CAIRN_DATA";
    const Score ours = score_of_image(*scene, full_size_match(*scene, "sgm", count));
    const Score peer = score_of_image(*scene, full_size_match(*scene, "3way", count));
    std::printf(
        "%-11s bad2, density, bad2+invalid: sgm %4.1f %5.1f %4.1f | 3way %4.1f %5.1f %4.1f\n", name,
        100 * ours.bad2, 100 * ours.density, 100 * ours.bad2_invalid, 100 * peer.bad2,
        100 * peer.density, 100 * peer.bad2_invalid);
    sgm.add(ours);
    three_way.add(peer);
  }
  EXPECT_LT(sgm.bad2(), three_way.bad2());
  EXPECT_LT(sgm.bad2_invalid(), three_way.bad2_invalid() + 0.01);
}

TEST(BenchmarkPairs, SgmLosesLittleToAnotherExposure) {
  auto scene = load_scene("adirondack");
  if (!scene) GTEST_SKIP() << "the real stereo pairs are not here; set CAIRN_DATA";
  const auto loss = [&](const char* matcher) {
    Scene exposed = *scene;
    exposed.right =
        cv::imread((*testing::data_folder() / "stereo/gt/adirondack/right_exposure.png").string(),
                   cv::IMREAD_GRAYSCALE);
    return score_of_image(exposed, full_size_match(exposed, matcher, 64)).bad2_invalid -
           score_of_image(*scene, full_size_match(*scene, matcher, 64)).bad2_invalid;
  };
  const double ours = loss("sgm");
  const double peer = loss("3way");
  std::printf("adirondack, other exposure: bad2+invalid grows by %.1f with sgm, %.1f with 3way\n",
              100 * ours, 100 * peer);
  EXPECT_LT(ours, peer / 3);
}

TEST(BenchmarkPairs, MoreConfidenceMeansFewerWrongAnswers) {
  for (const auto& [name, count] : {std::pair{"teddy", 64}, {"cones", 64}, {"motorcycle", 64}}) {
    const auto scene = load_scene(name);
    if (!scene) GTEST_SKIP() << "the real stereo pairs are not here; set CAIRN_DATA";
    for (const char* matcher : {"3way", "sgm"}) {
      SCOPED_TRACE(std::string(name) + " " + matcher);
      const auto image = full_size_match(*scene, matcher, count);
      std::array<Score, 4> by_level;
      for (int level = 0; level < 4; ++level) {
        by_level[static_cast<std::size_t>(level)] = score_of(*scene, [&](int row, int col) {
          return image.valid(row, col) && image.code(row, col) == level
                     ? image.disparity_px(row, col)
                     : 0.0;
        });
      }
      std::printf("%-11s %-4s bad2 (share) by confidence:", name, matcher);
      for (const Score& s : by_level) std::printf("  %5.1f (%4.1f)", 100 * s.bad2, 100 * s.density);
      std::printf("\n");
      EXPECT_LT(by_level[3].bad2, by_level[2].bad2);
      EXPECT_LT(by_level[2].bad2, by_level[1].bad2);
      EXPECT_LT(by_level[1].bad2, by_level[0].bad2);
      EXPECT_GT(by_level[3].density, 0.1);
    }
  }
}

TEST(BenchmarkPairs, MotorcycleHasItsTrueSizeInMetres) {
  const auto scene = load_scene("motorcycle");
  if (!scene) GTEST_SKIP() << "the real stereo pairs are not here; set CAIRN_DATA";
  RectifiedCamera camera = scene->camera();
  camera.f_px = 994.978;
  camera.cx_px = 311.193;
  camera.cy_px = 254.877;
  camera.doffs_px = 31.086;
  camera.baseline_m = 0.193001;
  for (const int downscale : {1, 2}) {
    MatcherConfig config;
    config.downscale = downscale;
    config.max_disparity_px = 64;
    const auto matcher = make_matcher(config);
    ASSERT_TRUE(matcher);
    const auto image = (*matcher)->match(scene->left, scene->right, camera, 0);
    ASSERT_TRUE(image);
    std::vector<double> errors_m;
    for (int row = 0; row + 1 < image->rows(); ++row) {
      for (int col = 0; col + 1 < image->cols(); ++col) {
        const double d_px = static_cast<double>(scene->truth_px(2 * row, 2 * col));
        if (!image->valid(row, col) || !(d_px > 0)) continue;
        const double z_m = 994.978 * 0.193001 / (d_px + 31.086);
        EXPECT_GT(z_m, 2.0);
        EXPECT_LT(z_m, 5.1);
        errors_m.push_back(std::abs(image->depth_m(row, col) - z_m));
      }
    }
    const auto middle = errors_m.begin() + static_cast<std::ptrdiff_t>(errors_m.size() / 2);
    std::nth_element(errors_m.begin(), middle, errors_m.end());
    std::printf("motorcycle, downscale %d: median depth error %.1f mm over %zu answers\n",
                downscale, 1000 * *middle, errors_m.size());
    // A quarter of a pixel at the median depth of 3.2 m is 13 mm.
    EXPECT_LT(*middle, downscale == 1 ? 0.013 : 0.02);
    EXPECT_GT(errors_m.size(), 0.5 * 371 * 250);
  }
}

}  // namespace
}  // namespace cairn::stereo
