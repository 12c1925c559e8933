// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "core/result.hpp"
#include "stereo/matcher.hpp"

namespace cairn::stereo {

/// Our own semi-global matcher (path_aggregation.hpp, then winner_checks.hpp). The range at the
/// size matched at must hold 2 to 256 disparities. Works on as many threads as cv::getNumThreads
/// says, at most two.
[[nodiscard]] Result<std::unique_ptr<Matcher>> make_sgm_matcher(const MatcherConfig& config);

}  // namespace cairn::stereo
