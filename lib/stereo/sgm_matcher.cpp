// SPDX-License-Identifier: Apache-2.0
#include "stereo/sgm_matcher.hpp"

#include <string>

#include "stereo/matched_size.hpp"
#include "stereo/path_aggregation.hpp"
#include "stereo/pixel_grading.hpp"
#include "stereo/winner_checks.hpp"

namespace cairn::stereo {
namespace {

constexpr int kMaxDisparities = 256;
constexpr int kMinSide_px = 16;
constexpr int kSpeckleRange_px = 2;

SearchRange search_range(const MatcherConfig& config) {
  return {config.min_disparity_px / config.downscale,
          (config.max_disparity_px + config.downscale - 1) / config.downscale};
}

class SgmMatcher final : public Matcher {
 public:
  explicit SgmMatcher(const MatcherConfig& config) : config_{config} {}

  Result<DisparityImage> match(const cv::Mat& left, const cv::Mat& right,
                               const RectifiedCamera& camera, Utime utime) override {
    if (auto ok = check_pair(left, right, camera, kMinSide_px * config_.downscale); !ok) {
      return tl::make_unexpected(ok.error());
    }
    try {
      const SearchRange range = search_range(config_);
      const cv::Mat left_matched = at_matched_size(left, config_);
      const cv::Mat right_matched = at_matched_size(right, config_);
      aggregate_paths(left_matched, right_matched, range, Penalties{}, cv::getNumThreads(),
                      winners_);
      const auto raw = standing_winners(winners_, range, config_.uniqueness_percent);
      const GradedPixels graded = grade_pixels(left_matched, raw, range, config_.speckle_size_px,
                                               kSpeckleRange_px, winner_confidence(winners_));
      return on_grid(graded, config_, camera, utime);
    } catch (const cv::Exception& exception) {
      return fail(std::string("stereo pair: ") + exception.what());
    }
  }

 private:
  MatcherConfig config_;
  Winners winners_;
};

}  // namespace

Result<std::unique_ptr<Matcher>> make_sgm_matcher(const MatcherConfig& config) {
  const SearchRange range = search_range(config);
  const int count = range.end_px - range.min_px;
  if (count < 2 || count > kMaxDisparities) {
    return fail("max_disparity_px: sgm searches 2 to " + std::to_string(kMaxDisparities) +
                " disparities at the size matched at, not " + std::to_string(count));
  }
  return std::make_unique<SgmMatcher>(config);
}

}  // namespace cairn::stereo
