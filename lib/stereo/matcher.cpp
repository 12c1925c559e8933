// SPDX-License-Identifier: Apache-2.0
#include "stereo/matcher.hpp"

#include "stereo/block_matcher.hpp"
#include "stereo/sgm_matcher.hpp"

namespace cairn::stereo {

Result<std::unique_ptr<Matcher>> make_matcher(const MatcherConfig& config) {
  if (config.min_disparity_px < 0) return fail("min_disparity_px: must not be negative");
  if (config.max_disparity_px <= config.min_disparity_px) {
    return fail("max_disparity_px: must be above min_disparity_px");
  }
  if (config.downscale != 1 && config.downscale != 2) return fail("downscale: must be 1 or 2");
  if (config.output_step_px != 1 && config.output_step_px != 2) {
    return fail("output_step_px: must be 1 or 2");
  }
  if (config.output_step_px < config.downscale) {
    return fail("output_step_px: 1 needs downscale 1");
  }
  if (config.method == "block") return make_block_matcher(config);
  if (config.method == "sgm") return make_sgm_matcher(config);
  return fail("method: no matcher is called '" + config.method + "'");
}

}  // namespace cairn::stereo
