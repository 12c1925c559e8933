// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cairn/rig_calibration_t.hpp>
#include <cairn/stereo_frame_t.hpp>
#include <optional>

#include "core/result.hpp"
#include "core/state_folder.hpp"
#include "messages/calibration_memory.hpp"
#include "messages/check.hpp"
#include "messages/image_messages.hpp"
#include "stereo/rectifier.hpp"

namespace cairn::messages {

/// Turns STEREO_FRAME and CALIBRATION into rectified pairs, for every process that looks at images.
class RectifiedFrames {
 public:
  explicit RectifiedFrames(const StateFolder& state) : calibrations_{state} {}

  [[nodiscard]] Result<void> put(const rig_calibration_t& calibration) {
    return calibrations_.put(calibration);
  }

  /// Refuses a frame whose calibration has not been heard of, images that are damaged, and a rig
  /// that cannot be rectified.
  [[nodiscard]] Result<stereo::RectifiedPair> rectify(const stereo_frame_t& frame) {
    if (auto good = check(frame); !good) return tl::make_unexpected(good.error());
    const camera::RigCalibration* rig = calibrations_.find(frame.calibration_id);
    if (rig == nullptr) return fail("its CALIBRATION has not been heard yet");
    if (!rectifier_ || calibration_id_ != frame.calibration_id) {
      auto rectifier = stereo::Rectifier::create(*rig);
      if (!rectifier) return tl::make_unexpected(rectifier.error());
      rectifier_.emplace(std::move(*rectifier));
      calibration_id_ = frame.calibration_id;
    }
    const auto images = to_images(frame);
    if (!images) return tl::make_unexpected(images.error());
    return rectifier_->rectify(images->left, images->right);
  }

  /// Of the newest frame that was rectified.
  [[nodiscard]] const stereo::Rectifier& rectifier() const { return *rectifier_; }

 private:
  CalibrationMemory calibrations_;
  std::optional<stereo::Rectifier> rectifier_;
  std::int64_t calibration_id_ = 0;
};

}  // namespace cairn::messages
