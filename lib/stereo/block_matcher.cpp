// SPDX-License-Identifier: Apache-2.0
#include "stereo/block_matcher.hpp"

#include <array>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <string_view>
#include <utility>

#include "stereo/matched_size.hpp"
#include "stereo/pixel_grading.hpp"

namespace cairn::stereo {
namespace {

constexpr int kDisparityMultiple = 16;  // OpenCV takes only multiples of this as the count searched
constexpr int kBmBlock_px = 15;
constexpr int kSgmBlock_px = 5;
constexpr int kPreFilterCap = 31;
constexpr int kSpeckleRange_px = 2;
constexpr int kMinSide_px = 32;

constexpr std::array<std::pair<std::string_view, int>, 4> kSgmModes{
    {{"3way", cv::StereoSGBM::MODE_SGBM_3WAY},
     {"sgbm", cv::StereoSGBM::MODE_SGBM},
     {"hh", cv::StereoSGBM::MODE_HH},
     {"hh4", cv::StereoSGBM::MODE_HH4}}};

/// The range searched, in pixels of the size matched at.
SearchRange search_range(const MatcherConfig& config) {
  const int min_px = config.min_disparity_px / config.downscale;
  const int end_px = (config.max_disparity_px + config.downscale - 1) / config.downscale;
  const int blocks = (end_px - min_px + kDisparityMultiple - 1) / kDisparityMultiple;
  return {min_px, min_px + blocks * kDisparityMultiple};
}

cv::Ptr<cv::StereoMatcher> make_opencv_matcher(const MatcherConfig& config,
                                               const SearchRange& range) {
  const int count = range.end_px - range.min_px;
  if (config.variant == "bm") {
    auto bm = cv::StereoBM::create(count, kBmBlock_px);
    bm->setMinDisparity(range.min_px);
    bm->setPreFilterCap(kPreFilterCap);
    bm->setUniquenessRatio(config.uniqueness_percent);
    bm->setDisp12MaxDiff(1);
    return bm;
  }
  for (const auto& [name, mode] : kSgmModes) {
    if (name != config.variant) continue;
    const int area = kSgmBlock_px * kSgmBlock_px;
    return cv::StereoSGBM::create(range.min_px, count, kSgmBlock_px, 8 * area, 32 * area, 1,
                                  kPreFilterCap, config.uniqueness_percent, 0, 0, mode);
  }
  return nullptr;
}

class BlockMatcher final : public Matcher {
 public:
  BlockMatcher(const MatcherConfig& config, const SearchRange& range,
               cv::Ptr<cv::StereoMatcher> opencv)
      : config_{config}, range_{range}, opencv_{std::move(opencv)} {}

  Result<DisparityImage> match(const cv::Mat& left, const cv::Mat& right,
                               const RectifiedCamera& camera, Utime utime) override {
    if (auto ok = check_pair(left, right, camera, kMinSide_px * config_.downscale); !ok) {
      return tl::make_unexpected(ok.error());
    }
    try {
      const cv::Mat left_matched = at_matched_size(left, config_);
      const cv::Mat right_matched = at_matched_size(right, config_);
      const cv::Mat_<std::int16_t> raw = raw_disparity(left_matched, right_matched);
      const GradedPixels graded =
          grade_pixels(left_matched, raw, range_, config_.speckle_size_px, kSpeckleRange_px);
      return on_grid(graded, config_, camera, utime);
    } catch (const cv::Exception& exception) {
      return fail(std::string("stereo pair: ") + exception.what());
    }
  }

 private:
  /// OpenCV leaves the first min + count columns unanswered: the images are widened on the left by
  /// that much.
  cv::Mat_<std::int16_t> raw_disparity(const cv::Mat& left, const cv::Mat& right) {
    const int pad = range_.end_px;
    cv::copyMakeBorder(left, padded_left_, 0, 0, pad, 0, cv::BORDER_REPLICATE);
    cv::copyMakeBorder(right, padded_right_, 0, 0, pad, 0, cv::BORDER_REPLICATE);
    opencv_->compute(padded_left_, padded_right_, padded_disparity_);
    return padded_disparity_(cv::Rect(pad, 0, left.cols, left.rows)).clone();
  }

  MatcherConfig config_;
  SearchRange range_;
  cv::Ptr<cv::StereoMatcher> opencv_;
  cv::Mat padded_left_;
  cv::Mat padded_right_;
  cv::Mat padded_disparity_;
};

}  // namespace

Result<std::unique_ptr<Matcher>> make_block_matcher(const MatcherConfig& config) {
  const SearchRange range = search_range(config);
  auto opencv = make_opencv_matcher(config, range);
  if (opencv == nullptr)
    return fail("variant: no block matcher is called '" + config.variant + "'");
  return std::make_unique<BlockMatcher>(config, range, std::move(opencv));
}

}  // namespace cairn::stereo
