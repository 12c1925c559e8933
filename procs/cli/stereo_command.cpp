// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <cstdio>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "camera/rig_calibration.hpp"
#include "procs/cli/command.hpp"
#include "stereo/disparity_png.hpp"
#include "stereo/matcher.hpp"
#include "stereo/rectifier.hpp"

namespace cairn::cli {
namespace {

struct Options {
  std::string left;
  std::string right;
  std::string calibration;
  std::string out;
  stereo::MatcherConfig matcher;
  bool json = false;
};

Result<cv::Mat> read_grey(const std::string& file) {
  cv::Mat image = cv::imread(file, cv::IMREAD_GRAYSCALE);
  if (image.empty()) return fail(file + ": is no image that can be read");
  return image;
}

// Without a calibration the pair is taken as rectified; then the disparities count and the depths
// do not.
Result<camera::RigCalibration> rig_of(const Options& options, const cv::Mat& left) {
  if (!options.calibration.empty()) return camera::load_rig(options.calibration);
  return camera::rectified_rig(1, 1, 0, 0, 1, left.cols, left.rows, Isometry::Identity());
}

Result<stereo::DisparityImage> match(const Options& options) {
  const auto left = read_grey(options.left);
  if (!left) return tl::make_unexpected(left.error());
  const auto right = read_grey(options.right);
  if (!right) return tl::make_unexpected(right.error());
  const auto rig = rig_of(options, *left);
  if (!rig) return tl::make_unexpected(rig.error());
  const auto rectifier = stereo::Rectifier::create(*rig);
  if (!rectifier) return tl::make_unexpected(rectifier.error());
  const auto pair = rectifier->rectify(*left, *right);
  if (!pair) return tl::make_unexpected(pair.error());
  const auto matcher = stereo::make_matcher(options.matcher);
  if (!matcher) return tl::make_unexpected(matcher.error());
  return (*matcher)->match(pair->left, pair->right, rectifier->camera(), 0);
}

int print(const Options& options, const stereo::DisparityImage& seen) {
  int answers = 0;
  double least = std::numeric_limits<double>::infinity();
  double most = 0;
  for (int row = 0; row < seen.rows(); ++row) {
    for (int col = 0; col < seen.cols(); ++col) {
      if (!seen.valid(row, col)) continue;
      ++answers;
      least = std::min(least, seen.disparity_px(row, col));
      most = std::max(most, seen.disparity_px(row, col));
    }
  }
  const double density =
      static_cast<double>(answers) / (static_cast<double>(seen.rows()) * seen.cols());
  if (options.json) {
    nlohmann::ordered_json json{{"method", options.matcher.method},
                                {"width", seen.cols()},
                                {"height", seen.rows()},
                                {"density", density}};
    json["min_disparity_px"] = answers > 0 ? nlohmann::ordered_json(least) : nullptr;
    json["max_disparity_px"] = answers > 0 ? nlohmann::ordered_json(most) : nullptr;
    std::cout << json.dump(2) << "\n";
    return 0;
  }
  std::printf("%d x %d, %.1f %% answered", seen.cols(), seen.rows(), 100 * density);
  if (answers > 0) std::printf(", disparity %.2f to %.2f px", least, most);
  std::printf("%s%s\n", options.out.empty() ? "" : "; written to ", options.out.c_str());
  return 0;
}

int stereo(const Options& options) {
  const auto seen = match(options);
  if (!seen) return failed(seen.error().message);
  if (!options.out.empty()) {
    if (auto written = stereo::write_disparity_png(options.out, *seen); !written)
      return failed(written.error().message);
  }
  return print(options, *seen);
}

}  // namespace

void add_stereo(CLI::App& app, Run& run) {
  auto options = std::make_shared<Options>();
  options->matcher.downscale = 1;
  options->matcher.output_step_px = 1;
  CLI::App* command = app.add_subcommand("stereo", "match one pair of images");
  command->add_option("left", options->left, "left image")->required();
  command->add_option("right", options->right, "right image")->required();
  command->add_option("--method", options->matcher.method, "how")
      ->check(CLI::IsMember({"block", "sgm"}))
      ->capture_default_str();
  command->add_option("--variant", options->matcher.variant, "which of OpenCV's, for method block")
      ->check(CLI::IsMember({"bm", "3way", "sgbm", "hh", "hh4"}))
      ->capture_default_str();
  command
      ->add_option("--max-disparity", options->matcher.max_disparity_px,
                   "disparities below this are searched [px]; rounded up to a multiple of 16")
      ->check(CLI::Range(16, 1024))
      ->capture_default_str();
  command->add_option("--calibration", options->calibration,
                      "rig file; without one the pair is taken as rectified");
  command->add_option("--out", options->out, "16-bit PNG: disparity x 256, 0 = no answer");
  command->add_flag("--json", options->json, "print JSON instead of words");
  command->footer(
      "Example:\n  cairn stereo left.png right.png --max-disparity 64 --out disparity.png");
  command->callback([&run, options] { run = [options] { return stereo(*options); }; });
}

}  // namespace cairn::cli
