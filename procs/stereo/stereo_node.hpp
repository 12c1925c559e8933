// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "bus/node.hpp"
#include "messages/rectified_frames.hpp"
#include "stereo/matcher.hpp"

namespace cairn {

/// stereo: depth. Turns each STEREO_FRAME into DISPARITY; where frames come faster than it works,
/// older ones are skipped.
class StereoNode {
 public:
  using Config = stereo::MatcherConfig;
  static constexpr const char* kName = "stereo";
  static constexpr const char* kAbout = "stereo: turns STEREO_FRAME into DISPARITY";

  /// Nothing if create would take this config; else the key whose value makes no sense beside the
  /// others.
  [[nodiscard]] static Result<void> check(const Config& config);
  [[nodiscard]] static Result<std::unique_ptr<StereoNode>> create(const Config& config,
                                                                  bus::Node& node);

  StereoNode(std::unique_ptr<stereo::Matcher> matcher, bus::Node& node);

  [[nodiscard]] Result<void> finish() { return {}; }

 private:
  void match(const stereo_frame_t& frame);

  bus::Node& node_;
  messages::RectifiedFrames frames_;
  std::unique_ptr<stereo::Matcher> matcher_;
};

}  // namespace cairn
