// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "core/result.hpp"
#include "stereo/matcher.hpp"

namespace cairn::stereo {

/// OpenCV's matchers: `bm` (block matching, SAD over 15x15), and semi-global matching
/// (Hirschmueller 2008) with the cost of Birchfield and Tomasi (1998) over 5x5 along 3 (`3way`), 5
/// (`sgbm`), 4 (`hh4`) or 8 (`hh`) paths.
[[nodiscard]] Result<std::unique_ptr<Matcher>> make_block_matcher(const MatcherConfig& config);

}  // namespace cairn::stereo
