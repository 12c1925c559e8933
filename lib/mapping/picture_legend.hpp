// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace cairn::mapping {

/// A sign and what it stands for. The sign is a picture of its own.
struct LegendItem {
  cv::Mat sign;  ///< BGR, at most 24 pixels high
  std::string text;
};

/// The picture with a white strip of its own below it, so that it covers nothing: a scale bar of
/// about a quarter of the width, then the items, in as many rows as they need.
[[nodiscard]] cv::Mat with_legend(const cv::Mat& picture, double pixels_per_m,
                                  const std::vector<LegendItem>& items);

}  // namespace cairn::mapping
